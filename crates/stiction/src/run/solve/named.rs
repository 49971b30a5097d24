//! Numbers by name, as files have them.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value};

/// Numbers by name, in order. In a file `null` stands for a number that is not finite and is read as infinite.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Named(pub Vec<(String, f64)>);

impl Named {
    /// The number called `name`.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|entry| entry.0 == name).map(|entry| entry.1)
    }
}

impl Serialize for Named {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

impl<'de> Deserialize<'de> for Named {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let number = |(name, value): (String, Value)| {
            let value = Option::deserialize(value).map_err(D::Error::custom)?;
            Ok((name, value.unwrap_or(f64::INFINITY)))
        };
        Map::deserialize(deserializer)?.into_iter().map(number).collect::<Result<_, _>>().map(Named)
    }
}
