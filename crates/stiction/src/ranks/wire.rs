/// What goes into messages: numbers, little-endian, and arrays of them.
pub trait Wire: Copy {
    /// Bytes of one.
    const SIZE: usize;
    /// Appends it.
    fn write(&self, to: &mut Vec<u8>);
    /// From its first [`Self::SIZE`] bytes.
    ///
    /// # Panics
    /// If there are fewer.
    fn read(from: &[u8]) -> Self;
}

macro_rules! number {
    ($($t:ty),*) => {$(
        impl Wire for $t {
            const SIZE: usize = size_of::<$t>();
            fn write(&self, to: &mut Vec<u8>) {
                to.extend_from_slice(&self.to_le_bytes());
            }
            fn read(from: &[u8]) -> Self {
                let (bytes, _) = from.split_first_chunk().expect("a message of whole numbers");
                <$t>::from_le_bytes(*bytes)
            }
        }
    )*};
}

number!(u8, u32, u64, f32, f64);

impl<T: Wire, const N: usize> Wire for [T; N] {
    const SIZE: usize = N * T::SIZE;

    fn write(&self, to: &mut Vec<u8>) {
        self.iter().for_each(|value| value.write(to));
    }

    fn read(from: &[u8]) -> Self {
        std::array::from_fn(|k| T::read(&from[k * T::SIZE..]))
    }
}

/// Values one after the other.
pub fn to_bytes<T: Wire>(values: &[T]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(values.len() * T::SIZE);
    values.iter().for_each(|value| value.write(&mut bytes));
    bytes
}

/// The inverse of [`to_bytes`].
pub fn from_bytes<T: Wire>(bytes: &[u8]) -> Vec<T> {
    bytes.chunks_exact(T::SIZE).map(T::read).collect()
}

/// Appends a list with its length.
pub fn put<T: Wire>(list: &[T], to: &mut Vec<u8>) {
    (list.len() as u64).write(to);
    to.extend(to_bytes(list));
}

/// Takes the next list of a message that [`put`] has made.
///
/// # Panics
/// If the message is shorter.
pub fn take<T: Wire>(from: &mut &[u8]) -> Vec<T> {
    let (count, rest) = from.split_at(8);
    let (list, rest) = rest.split_at(u64::read(count) as usize * T::SIZE);
    *from = rest;
    from_bytes(list)
}
