use hmac::{Hmac, Mac};
use sha2::Sha256;
use thiserror::Error;

use super::packet::{CODE_BYTES, PACKET_BYTES, Packet, SIGNED_BYTES};

pub const MIN_KEY_BYTES: usize = 16;

pub(super) const NONCE_BYTES: usize = 16;

/// Separates session keys from packet codes that use the same key.
const SESSION: &[u8] = b"trocar link, key of a session";

#[derive(Debug, Error)]
#[error("the key has {given} bytes, must have at least {MIN_KEY_BYTES}: make one with head -c 32 /dev/urandom")]
pub struct KeyError {
    pub given: usize,
}

/// A key for HMAC with SHA-256; the first 128 bits of a code are sent (RFC 2104).
#[derive(Clone)]
pub struct Key(Hmac<Sha256>);

impl Key {
    pub fn new(bytes: &[u8]) -> Result<Self, KeyError> {
        if bytes.len() < MIN_KEY_BYTES { Err(KeyError { given: bytes.len() }) } else { Ok(Self::of(bytes)) }
    }

    /// The key of links on one computer only detects errors and foreign packets.
    pub fn of_loopback() -> Self {
        Self::of(b"loopback")
    }

    fn of(bytes: &[u8]) -> Self {
        let mut block = [0; 64];
        let (length, hashed);
        if bytes.len() > block.len() {
            hashed = <Sha256 as sha2::Digest>::digest(bytes);
            length = hashed.len();
            block[..length].copy_from_slice(&hashed);
        } else {
            length = bytes.len();
            block[..length].copy_from_slice(bytes);
        }
        Self(Hmac::new(&block.into()))
    }

    pub(super) fn session(&self, of_master: &[u8; NONCE_BYTES], of_slave: &[u8; NONCE_BYTES]) -> Session {
        let mut code = self.0.clone();
        code.update(SESSION);
        code.update(of_master);
        code.update(of_slave);
        Session(Self::of(&code.finalize().into_bytes()))
    }

    pub(super) fn seal(&self, packet: &Packet) -> [u8; PACKET_BYTES] {
        let mut bytes = packet.bytes();
        let mut code = self.0.clone();
        code.update(&bytes[..SIGNED_BYTES]);
        bytes[SIGNED_BYTES..].copy_from_slice(&code.finalize().into_bytes()[..CODE_BYTES]);
        bytes
    }

    /// The duration of the comparison does not depend on the code.
    pub(super) fn is_authentic(&self, bytes: &[u8]) -> bool {
        let Some((signed, code)) = bytes.split_at_checked(SIGNED_BYTES).filter(|(_, code)| code.len() == CODE_BYTES)
        else {
            return false;
        };
        let mut expected = self.0.clone();
        expected.update(signed);
        expected.verify_truncated_left(code).is_ok()
    }
}

impl std::fmt::Debug for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Key")
    }
}

#[derive(Debug, Clone)]
pub struct Session(pub(super) Key);

#[cfg(test)]
mod tests {
    use super::super::packet::{BODY_BYTES, Kind, Role};
    use super::*;

    const PACKET: Packet =
        Packet { kind: Kind::Message, from: Role::Master, number: 7, tick: 9, sent_ns: 5, body: [3; BODY_BYTES] };

    #[test]
    fn a_changed_bit_or_another_key_is_detected() {
        let key = Key::new(b"sixteen bytes ok").expect("long enough");
        let sealed = key.seal(&PACKET);
        assert!(key.is_authentic(&sealed));
        for bit in 0..8 * PACKET_BYTES {
            let mut changed = sealed;
            changed[bit / 8] ^= 1 << (bit % 8);
            assert!(!key.is_authentic(&changed), "{bit}");
        }
        assert!(!Key::new(b"sixteen bytes OK").expect("long enough").is_authentic(&sealed));
        assert!(!Key::of_loopback().is_authentic(&sealed));
        assert!(!key.is_authentic(&sealed[..PACKET_BYTES - 1]) && !key.is_authentic(&[]));
        assert!(Key::new(b"fifteen bytes !").is_err());
    }

    #[test]
    fn another_session_has_another_key() {
        let key = Key::of_loopback();
        let sealed = key.session(&[1; NONCE_BYTES], &[2; NONCE_BYTES]).0.seal(&PACKET);
        assert!(key.session(&[1; NONCE_BYTES], &[2; NONCE_BYTES]).0.is_authentic(&sealed));
        assert!(!key.session(&[2; NONCE_BYTES], &[1; NONCE_BYTES]).0.is_authentic(&sealed));
        assert!(!key.is_authentic(&sealed));
    }

    #[test]
    fn the_code_agrees_with_rfc_4231() {
        // Test cases 2 and 6: a short key, and a key longer than a block.
        let code = |key: &[u8], text: &[u8]| {
            let mut code = Key::of(key).0;
            code.update(text);
            code.finalize().into_bytes()[..4].to_vec()
        };
        assert_eq!(code(b"Jefe", b"what do ya want for nothing?"), [0x5b, 0xdc, 0xc1, 0x46]);
        let long = b"Test Using Larger Than Block-Size Key - Hash Key First";
        assert_eq!(code(&[0xaa; 131], long), [0x60, 0xe4, 0x31, 0x59]);
    }
}
