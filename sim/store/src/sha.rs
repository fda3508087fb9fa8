//! SHA-256.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use sha2::{Digest, Sha256};

/// SHA-256 in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha(Sha256::new_with_prefix(bytes)).hexadecimal()
}

/// SHA-256 of a script as a page's policy admits it.
pub fn sha256_in_base64(text: &str) -> String {
    BASE64_STANDARD.encode(Sha256::digest(text.as_bytes()))
}

/// SHA-256 of what is written to it, piece by piece.
#[derive(Clone, Default)]
pub struct Sha(Sha256);

impl Sha {
    /// Of all that was written, in hexadecimal.
    pub fn hexadecimal(self) -> String {
        self.0.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

impl std::io::Write for Sha {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}
