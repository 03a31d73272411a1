//! The keys of the mutator: of the artist, of keys that she trusts or has revoked, and of a stranger.
//!
//! Owns signing of any text with any of them, also of texts that our tools refuse to sign, since a careless or stolen
//! key may do that.
//!
//! Start at [`Keys::sign`].

use ct_codecs::{Base64, Decoder, Encoder};
use minisign::{PublicKey, SecretKey, SecretKeyBox};
use std::fs;
use std::io::Cursor;
use std::path::Path;

/// The passphrase of the fixtures' keys.
const PASSPHRASE: &str = "velvet";
/// The first line of a statement.
const STATEMENT: &str = "dreams key statement 1\n";

/// Whose key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyHolder {
    /// Trusted by the unit.
    Artist,
    /// Trusted by the unit, too.
    Spare,
    /// Trusted by a statement of the artist, if the stick has it.
    New,
    /// Trusted by a statement of the artist and revoked, as the unit knows.
    Lost,
    /// Unknown.
    Stranger,
}

/// All keys.
pub struct Keys([SecretKey; 5]);

impl Keys {
    /// Reads those of `fixtures`.
    pub fn read(fixtures: &Path) -> Self {
        let key = |path: &str| {
            let text = fs::read_to_string(fixtures.join(path)).unwrap();
            let locked = SecretKeyBox::from_string(&text).unwrap();
            SecretKey::from_box(locked, Some(PASSPHRASE.to_owned())).unwrap()
        };
        let those = ["format-1/keys/artist.key", "format-1/keys/spare.key", "format-1/keys/new.key"];
        let [artist, spare, new] = those.map(key);
        Self([artist, spare, new, key("format-1/keys/lost.key"), key("keys/artist.key")])
    }

    fn secret(&self, who: KeyHolder) -> &SecretKey {
        &self.0[who as usize]
    }

    /// The line of this public key.
    pub fn line(&self, who: KeyHolder) -> String {
        PublicKey::from_secret_key(self.secret(who)).unwrap().to_base64()
    }

    /// The text of the file of this public key.
    pub fn public(&self, who: KeyHolder) -> String {
        PublicKey::from_secret_key(self.secret(who)).unwrap().to_box().unwrap().to_string()
    }

    /// The id of this key.
    pub fn id(&self, who: KeyHolder) -> String {
        let number = self.secret(who).keynum().try_into().expect("eight bytes");
        format!("{:016X}", u64::from_le_bytes(number))
    }

    /// `text`, signed with this key.
    pub fn sign(&self, who: KeyHolder, text: &[u8]) -> Vec<u8> {
        self.sign_beside(who, text, "a mutant")
    }

    /// The same with this comment.
    pub fn sign_beside(&self, who: KeyHolder, text: &[u8], comment: &str) -> Vec<u8> {
        let said = "signature from minisign secret key";
        let signature = minisign::sign(None, self.secret(who), Cursor::new(text), Some(comment), Some(said)).unwrap();
        [signature.to_string().trim_end().as_bytes(), b"\n", text].concat()
    }

    /// `text`, signed by `who` in the name of `other`.
    pub fn sign_as(&self, who: KeyHolder, other: KeyHolder, text: &[u8]) -> Vec<u8> {
        // The text may be a mutant already, and no UTF-8.
        let signed = self.sign(who, text);
        let mut lines: Vec<Vec<u8>> = signed.split_inclusive(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
        let mut raw = Base64::decode_to_vec(lines[1].trim_ascii_end(), None).unwrap();
        raw[2..10].copy_from_slice(self.secret(other).keynum());
        lines[1] = (Base64::encode_to_string(raw).unwrap() + "\n").into_bytes();
        lines.concat()
    }

    /// This public key under the id of `other`.
    pub fn line_as(&self, who: KeyHolder, other: KeyHolder) -> String {
        let mut raw = Base64::decode_to_vec(self.line(who), None).unwrap();
        raw[2..10].copy_from_slice(self.secret(other).keynum());
        Base64::encode_to_string(raw).unwrap()
    }

    /// The statement of `by` that `of` is trusted.
    pub fn trust(&self, by: KeyHolder, of: KeyHolder) -> Vec<u8> {
        self.state(by, &format!("trust {}", self.line(of)))
    }

    /// The artist's statement that revokes `of`.
    pub fn revoke(&self, of: KeyHolder) -> Vec<u8> {
        self.state(KeyHolder::Artist, &format!("revoke {}", self.id(of)))
    }

    /// A statement of `by` with the text `said`.
    pub fn state(&self, by: KeyHolder, said: &str) -> Vec<u8> {
        self.sign_beside(by, format!("{STATEMENT}{said}\n").as_bytes(), "a statement about a key")
    }
}
