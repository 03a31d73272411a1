//! Types of validated names: units, files of a flock, objects, sequences, versions.
//!
//! Owns their rules and spelling.
//!
//! Start at [`ObjectId`], the name of all content in a bundle.

use std::fmt;
use std::io::{self, Read};

use flock::excerpt;

use crate::limits;
use crate::refusal::Refusal;

/// The file stem of a seal for all units; not valid as a unit's name.
const ANYONE: &str = "all";
/// How many units are listed by name in messages.
const NAMED: usize = 3;
/// Bytes hashed at a time: with a quarter of it, verifying takes 3 % more processor time.
const CHUNK: usize = 256 << 10;

/// A unit's own name: 1 to 64 of `a-z 0-9 . _ -`, beginning with a letter or digit, and not `all`.
///
/// It is used as a file name, so there are no capitals: FAT ignores case.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct UnitId(String);

/// For whom a bundle is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Addressees {
    /// Every unit that trusts the key.
    Anyone,
    /// These units, at least one, sorted, none twice.
    Units(Vec<UnitId>),
}

/// The path of a file in its flock: relative, inside the folder, without `..`, written with `/`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FilePath(String);

/// The BLAKE3 digest of a file's bytes: the only name that content has. Written as 64 lower-case hex digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObjectId([u8; 32]);

/// The sequence number of a key's bundles: newer ones have higher numbers. At least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct Sequence(pub u64);

/// The version of a system: 1 to 4 whole numbers separated by dots. Newer ones are higher.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version(Vec<u64>);

/// Why a text is no such name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// No digest.
    #[error("wanted 64 hex digits, found `{found}`")]
    Object {
        /// As given, cut short.
        found: String,
    },
    /// A path that is empty, absolute, too long or too deep, or leaves the folder.
    #[error("wanted a relative path inside the folder, without `..`, found `{found}`")]
    Path {
        /// As given, cut short.
        found: String,
    },
    /// No sequence.
    #[error("wanted a whole number from 1, found `{found}`")]
    Sequence {
        /// As given, cut short.
        found: String,
    },
    /// A unit's name with invalid characters or length, or the reserved name `all`.
    #[error("wanted 1 to 64 of `a-z 0-9 . _ -`, a letter or digit first, and not `all`, found `{found}`")]
    Unit {
        /// As given, cut short.
        found: String,
    },
    /// No version of a system.
    #[error("wanted 1 to 4 whole numbers with dots between them, found `{found}`")]
    Version {
        /// As given, cut short.
        found: String,
    },
}

impl UnitId {
    /// The name `text`.
    ///
    /// # Errors
    /// [`NameError::Unit`] if it is not one.
    pub fn new(text: &str) -> Result<Self, NameError> {
        let allowed = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b"._-".contains(&b);
        let first = text.bytes().next().is_some_and(|b| b.is_ascii_alphanumeric());
        if first && text.len() <= limits::UNIT_NAME && text.bytes().all(allowed) && text != ANYONE {
            Ok(Self(text.to_owned()))
        } else {
            Err(NameError::Unit { found: excerpt(text) })
        }
    }

    /// The name as text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Addressees {
    /// These units, sorted and without duplicates; all units if the list is empty.
    pub fn of(units: impl IntoIterator<Item = UnitId>) -> Self {
        let mut units: Vec<UnitId> = units.into_iter().collect();
        units.sort();
        units.dedup();
        if units.is_empty() { Self::Anyone } else { Self::Units(units) }
    }

    /// Whether `unit` may install a bundle for these, if its last one was for `last`: a unit that was addressed by name
    /// takes no bundles for all units any more.
    ///
    /// # Errors
    /// [`Refusal::ForEverybody`] or [`Refusal::ForOthers`].
    pub fn admit(&self, unit: &UnitId, last: Option<&Self>) -> Result<(), Refusal> {
        if !self.include(unit) {
            return Err(Refusal::ForOthers { addressees: self.clone(), unit: unit.clone() });
        }
        match (self, last) {
            (Self::Anyone, Some(Self::Units(named))) if named.contains(unit) => {
                Err(Refusal::ForEverybody { unit: unit.clone() })
            }
            (Self::Anyone | Self::Units(_), _) => Ok(()),
        }
    }

    /// Whether `unit` is among them.
    pub fn include(&self, unit: &UnitId) -> bool {
        match self {
            Self::Anyone => true,
            Self::Units(units) => units.contains(unit),
        }
    }

    /// A summary for messages: the first three by name.
    pub fn summary(&self) -> String {
        match self {
            Self::Anyone => ANYONE.to_owned(),
            Self::Units(units) => few(units),
        }
    }

    /// The file stems of seals for them: one for each unit.
    pub fn file_stems(&self) -> Vec<&str> {
        match self {
            Self::Anyone => vec![ANYONE],
            Self::Units(units) => units.iter().map(UnitId::as_str).collect(),
        }
    }
}

impl FilePath {
    /// The path `text`.
    ///
    /// # Errors
    /// [`NameError::Path`] if it is empty, absolute, longer than 255 bytes or deeper than 8 parts, has `.`, `..` or
    /// empty parts, a backslash or a control character.
    pub fn new(text: &str) -> Result<Self, NameError> {
        let part_is_fine = |part: &str| !matches!(part, "" | "." | "..");
        let char_is_fine = |c: char| !c.is_control() && c != '\\';
        let fine = text.len() <= limits::PATH
            && text.split('/').count() <= limits::PATH_PARTS
            && text.split('/').all(part_is_fine)
            && text.chars().all(char_is_fine);
        if fine { Ok(Self(text.to_owned())) } else { Err(NameError::Path { found: excerpt(text) }) }
    }

    /// A path of one plain word.
    pub(crate) fn word(word: &'static str) -> Self {
        Self(word.to_owned())
    }

    /// The path as text.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Its folders, outermost first.
    pub fn folders(&self) -> impl Iterator<Item = &str> {
        self.0.match_indices('/').map(|(at, _)| &self.0[..at])
    }
}

impl ObjectId {
    /// The name of content with this digest.
    pub fn new(digest: [u8; 32]) -> Self {
        Self(digest)
    }

    /// The name of `bytes`.
    pub fn of(bytes: &[u8]) -> Self {
        Self(*blake3::hash(bytes).as_bytes())
    }

    /// The name of everything that `reader` yields, and its length.
    ///
    /// # Errors
    /// The error of the reader.
    pub fn of_reader(mut reader: impl Read) -> io::Result<(Self, u64)> {
        let mut hasher = blake3::Hasher::new();
        let mut chunk = vec![0; CHUNK];
        loop {
            match reader.read(&mut chunk) {
                Ok(0) => return Ok((Self(*hasher.finalize().as_bytes()), hasher.count())),
                Ok(count) => hasher.update(&chunk[..count]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
        }
    }

    /// Reads 64 lower-case hex digits.
    ///
    /// # Errors
    /// [`NameError::Object`] if `text` has another form.
    pub fn parse(text: &str) -> Result<Self, NameError> {
        let refused = || NameError::Object { found: excerpt(text) };
        if text.bytes().any(|b| b.is_ascii_uppercase()) {
            return Err(refused());
        }
        blake3::Hash::from_hex(text).map(|hash| Self(*hash.as_bytes())).map_err(|_| refused())
    }

    /// The digest.
    pub fn as_bytes(&self) -> &[u8; 32] {
        &self.0
    }

    /// Its path in a bundle and in a store: `objects/ab/cdef...`.
    pub fn path(&self) -> String {
        let hex = blake3::Hash::from_bytes(self.0).to_hex();
        format!("objects/{}/{}", &hex[..2], &hex[2..])
    }
}

impl Sequence {
    /// Reads a whole number from 1, without a sign or leading zeros.
    ///
    /// # Errors
    /// [`NameError::Sequence`] if `text` has another form.
    pub fn parse(text: &str) -> Result<Self, NameError> {
        match parse_plain(text) {
            Some(number) if number > 0 => Ok(Self(number)),
            Some(_) | None => Err(NameError::Sequence { found: excerpt(text) }),
        }
    }
}

impl Version {
    /// Reads whole numbers with dots between them, each without leading zeros.
    ///
    /// # Errors
    /// [`NameError::Version`] if `text` has another form.
    pub fn parse(text: &str) -> Result<Self, NameError> {
        let numbers: Option<Vec<u64>> = text.split('.').take(limits::VERSION + 1).map(parse_plain).collect();
        let numbers = numbers.filter(|numbers| numbers.len() <= limits::VERSION);
        numbers.map(Self).ok_or_else(|| NameError::Version { found: excerpt(text) })
    }
}

/// The first three of `units`, and the number of the others.
pub fn few(units: &[UnitId]) -> String {
    let (named, others) = units.split_at(units.len().min(NAMED));
    let named = named.iter().map(UnitId::as_str).collect::<Vec<_>>().join(", ");
    if others.is_empty() { named } else { format!("{named} and {} more", others.len()) }
}

/// The number in `text`: digits only, no leading zeros.
pub(crate) fn parse_plain(text: &str) -> Option<u64> {
    let canonical = text.bytes().all(|b| b.is_ascii_digit()) && (text == "0" || !text.starts_with('0'));
    if canonical { text.parse().ok() } else { None }
}

impl fmt::Display for UnitId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl fmt::Display for Addressees {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file_stems().join(" "))
    }
}

impl fmt::Display for FilePath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl fmt::Display for ObjectId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", blake3::Hash::from_bytes(self.0))
    }
}

impl fmt::Display for Sequence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        f.write_str(&numbers.join("."))
    }
}

/// As a list of names, which is empty for everybody.
impl serde::Serialize for Addressees {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Anyone => serializer.collect_seq([""; 0]),
            Self::Units(units) => serializer.collect_seq(units.iter().map(UnitId::as_str)),
        }
    }
}

impl<'de> serde::Deserialize<'de> for Addressees {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let units = Vec::<String>::deserialize(deserializer)?;
        let units = units.iter().map(|unit| UnitId::new(unit)).collect::<Result<Vec<_>, _>>();
        units.map(Self::of).map_err(serde::de::Error::custom)
    }
}

impl serde::Serialize for Version {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl serde::Serialize for ObjectId {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> serde::Deserialize<'de> for ObjectId {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        Self::parse(&text).map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_a_plain_word_that_every_file_system_tells_from_the_others() {
        for fine in ["7", "lobby", "a-b_c.9", &"x".repeat(64)] {
            assert_eq!(UnitId::new(fine).unwrap().as_str(), fine);
        }
        for bad in ["", "all", "Lobby", "a b", "a/b", ".", "..", ".a", "-a", "ä", &"x".repeat(65)] {
            assert!(UnitId::new(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_path_cannot_leave_the_folder_nor_outgrow_it() {
        for fine in ["flock.toml", "loops/a.mp4", "a..b/c...mp4", "ä/b", &"x".repeat(255), "1/2/3/4/5/6/7/8"] {
            assert_eq!(FilePath::new(fine).unwrap().as_str(), fine);
        }
        let long = "x".repeat(256);
        for bad in [
            "",
            "/a",
            "../a",
            "a/../b",
            "a/..",
            "./a",
            "a//b",
            "a/",
            "a\\b",
            "a\0b",
            "a\nb",
            &long,
            "1/2/3/4/5/6/7/8/9",
        ] {
            assert!(FilePath::new(bad).is_err(), "{bad}");
        }
        assert_eq!(FilePath::new("a/b/c").unwrap().folders().collect::<Vec<_>>(), ["a", "a/b"]);
    }

    #[test]
    fn an_object_has_one_spelling() {
        let id = ObjectId::of(b"a clip");
        assert_eq!(ObjectId::parse(&id.to_string()), Ok(id));
        assert_eq!(id.path().len(), "objects/ab/".len() + 62);
        for bad in ["", "ab", &id.to_string().to_uppercase(), &format!("{id}0"), &format!("b3:{id}")] {
            assert!(ObjectId::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_sequence_has_one_spelling() {
        assert_eq!(Sequence::parse("7"), Ok(Sequence(7)));
        for bad in ["", "0", "07", "+7", "-7", "7 ", "18446744073709551616"] {
            assert!(Sequence::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_version_has_one_spelling_and_is_higher_if_it_is_newer() {
        let version = |text| Version::parse(text).unwrap();
        assert_eq!(version("0.10.2").to_string(), "0.10.2");
        assert!(version("0.2.0") < version("0.10.0") && version("0.10.0") < version("0.10.0.1"));
        for bad in ["", ".", "1.", "v1", "1.02", "1.2.3.4.5", "1.-2", "1.2-rc1", "99999999999999999999"] {
            assert!(Version::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn nobody_named_is_everybody() {
        let unit = |name| UnitId::new(name).unwrap();
        assert!(Addressees::of([]).include(&unit("lobby")));
        let two = Addressees::of([unit("stairs"), unit("lobby"), unit("stairs")]);
        assert_eq!(two.file_stems(), ["lobby", "stairs"]);
        assert!(two.include(&unit("lobby")) && !two.include(&unit("attic")));
        for addressees in [Addressees::Anyone, two] {
            let text = serde_json::to_string(&addressees).unwrap();
            assert_eq!(serde_json::from_str::<Addressees>(&text).unwrap(), addressees, "{text}");
        }
        assert!(serde_json::from_str::<Addressees>("[\"a b\"]").is_err());
    }

    #[test]
    fn who_was_addressed_by_name_takes_what_is_for_it_by_name() {
        let unit = |name| UnitId::new(name).unwrap();
        let (lobby, stairs) = (Addressees::of([unit("lobby")]), Addressees::of([unit("attic"), unit("stairs")]));
        let told = |to: &Addressees, last: Option<&Addressees>| match to.admit(&unit("lobby"), last) {
            Ok(()) => "taken".to_owned(),
            Err(refused) => refused.to_string(),
        };
        let everybody =
            "the bundle is for every unit, but this unit takes only bundles for `lobby` since it was given one";
        for (to, last, wanted) in [
            (&Addressees::Anyone, None, "taken"),
            (&Addressees::Anyone, Some(&Addressees::Anyone), "taken"),
            (&Addressees::Anyone, Some(&lobby), everybody),
            (&Addressees::Anyone, Some(&stairs), "taken"),
            (&lobby, None, "taken"),
            (&lobby, Some(&lobby), "taken"),
            (&lobby, Some(&Addressees::Anyone), "taken"),
            (&stairs, None, "the bundle is for `attic, stairs`, this unit is `lobby`"),
            (&stairs, Some(&stairs), "the bundle is for `attic, stairs`, this unit is `lobby`"),
        ] {
            assert_eq!(told(to, last), wanted, "{to} after {last:?}");
        }
    }

    #[test]
    fn no_more_than_three_units_are_told_by_name() {
        let units: Vec<UnitId> = ["a", "b", "c", "d", "e"].map(|name| UnitId::new(name).unwrap()).into();
        for (count, told) in [(0, ""), (1, "a"), (3, "a, b, c"), (4, "a, b, c and 1 more"), (5, "a, b, c and 2 more")] {
            assert_eq!(few(&units[..count]), told);
        }
    }
}
