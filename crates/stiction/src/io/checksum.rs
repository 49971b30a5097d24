//! SHA-256 of files and texts, in hexadecimal digits.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

use sha2::{Digest, Sha256};

/// Bytes read at a time: they stay in the cache between reading and hashing.
const PIECE: usize = 1 << 18;

/// The checksum of what a regular file holds; anything else of that name is not opened, for it might never end.
pub(crate) fn of_file(path: &Path) -> io::Result<String> {
    super::regular_file(path)?;
    let (mut file, mut hash, mut piece) = (File::open(path)?, Sha256::new(), vec![0; PIECE]);
    loop {
        match file.read(&mut piece) {
            Ok(0) => return Ok(format!("{:x}", hash.finalize())),
            Ok(bytes) => hash.update(&piece[..bytes]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

/// The checksum of a text.
pub(crate) fn of_text(text: &str) -> String {
    format!("{:x}", Sha256::digest(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// FIPS 180-2, appendix B.1 and B.3.
    #[test]
    fn the_examples_of_the_standard_come_out() {
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(of_text("abc"), abc);
        let path = std::env::temp_dir().join(format!("stiction-checksum-{}", std::process::id()));
        std::fs::write(&path, vec![b'a'; 1_000_000]).unwrap();
        let million = "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0";
        assert_eq!(of_file(&path).unwrap(), million);
        std::fs::remove_file(&path).unwrap();
        assert!(of_file(&std::env::temp_dir()).unwrap_err().to_string().contains("regular file"));
    }
}
