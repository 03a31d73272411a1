//! What a stranger may lay on a stick or a server, and what becomes of it: nothing.
//!
//! One unit stands before ten thousand bundles, each a good one with something done to it, or one that even the artist
//! could not make a unit swallow. None is installed, none costs more than time, and the good one still is.

use crate::astray::ASTRAY;
use crate::model::ModelDisk;
use crate::press::{Files, flock, key, press, trust, unit, verified};
use bundle::{
    Addressees, Admission, CURRENT, Consent, Contents, FileEntry, FilePath, Folder, ObjectId, Part, Refusal,
    STATEMENTS, SealBody, Sequence, SignError, Source, Statement, Store, UnverifiedSeal, VerifiedBundle, limits,
    seal_path,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::error::Error;
use std::io::{self, Read};
use std::rc::Rc;

/// So many forgeries.
const FORGERIES: u64 = 12_600;
/// So many bytes more than a bundle's own a unit may hold in memory while it refuses one, or reads the longest list.
const MEMORY: u64 = 64 << 20;

/// A source in memory that counts what is read from it.
#[derive(Clone, Default)]
struct Stall {
    wares: BTreeMap<String, Vec<u8>>,
    /// What is on it goes on for ever.
    is_endless: bool,
    read: Rc<Cell<u64>>,
}

struct Counted(Box<dyn Read>, Rc<Cell<u64>>);

/// A bundle with its content, ready to be tampered with.
struct Good {
    stall: Stall,
    bundle: VerifiedBundle,
    files: Files,
}

fn good(edition: usize, sequence: u64, units: &[&str]) -> Good {
    let (folder, files) = (tempfile::tempdir().unwrap(), flock(4, edition));
    press(folder.path(), &files, units, sequence, "artist");
    let stem = units.first().copied().unwrap_or("all");
    let mut source = Folder::open(folder.path()).unwrap();
    let to = Addressees::of(units.iter().map(|name| unit(name)));
    let seal = UnverifiedSeal::addressed(&mut source, &to).unwrap();
    let bundle = seal.clone().verify(&trust()).unwrap().fetch(&mut source).unwrap();
    let mut stall = Stall::default();
    stall.wares.insert(seal_path(stem), seal.bytes().to_vec());
    let list = bundle.contents_bytes().to_vec();
    for bytes in files.values().chain([&list]) {
        stall.wares.insert(ObjectId::of(bytes).path(), bytes.clone());
    }
    Good { stall, bundle, files }
}

/// Does with a source what an updater does; what it says in the end.
fn attempt(store: &mut Store, stall: &mut Stall) -> Result<(), Box<dyn Error>> {
    if let Ok(reader) = stall.small(STATEMENTS, limits::STATEMENTS) {
        let mut said = Vec::new();
        reader.take(limits::STATEMENTS).read_to_end(&mut said)?;
        store.learn(&said)?;
    }
    let seal = UnverifiedSeal::open(stall, &unit("lobby"))?.verify(store.trust())?;
    if store.admit(&seal, &unit("lobby"), Consent::Newer)? != Admission::New {
        return Err("no news".into());
    }
    let bundle = seal.fetch(stall)?;
    for wanted in store.plan(&bundle)?.wanted {
        let mut intake = store.intake(&wanted)?;
        let mut bytes = Vec::new();
        stall.object(&wanted.id, wanted.size, intake.have())?.take(intake.missing() + 1).read_to_end(&mut bytes)?;
        intake.append(&bytes)?;
        intake.finish()?;
    }
    store.install(&bundle)?;
    Ok(())
}

/// A unit that has played the artist's bundle 5, learned the spare key, and then that it was stolen.
fn unit_that_knows(disk: &ModelDisk, played: &mut Good) -> Store {
    let mut store = Store::open(Box::new(disk.clone()), trust()).unwrap();
    attempt(&mut store, &mut played.stall).unwrap();
    store.accept().unwrap();
    let spare = key("spare").public();
    let words =
        [Statement::Trust(spare.clone()), Statement::Revoke(spare.id())].map(|word| word.sign(key("artist")).unwrap());
    assert_eq!(store.learn(&words.concat()).unwrap().news.len(), 2);
    store
}

#[test]
fn none_of_ten_thousand_forgeries_is_accepted_and_none_costs_more_than_time() {
    let disk = ModelDisk::new(None);
    let mut played = good(0, 5, &["lobby"]);
    let mut store = unit_that_knows(&disk, &mut played);
    let genuine = good(1, 6, &["lobby"]);
    let others = good(2, 7, &["stairs"]);
    let mut reasons: BTreeMap<String, usize> = BTreeMap::new();
    for number in 0..FORGERIES {
        let mut random = ChaCha8Rng::seed_from_u64(number);
        let (kind, mut stall) = forge(number, &genuine, &others, &played, &mut random);
        stall.read.set(0);
        let mut tried = Ok(());
        let memory = allocation_counter::measure(|| tried = attempt(&mut store, &mut stall));
        let refused = tried.err().unwrap_or_else(|| panic!("accepted {number}: {kind}"));
        assert!(memory.bytes_max <= MEMORY, "{kind} took {} bytes of memory: {refused}", memory.bytes_max);
        *reasons.entry(kind.to_owned()).or_default() += 1;
        // The good beginning of a bad file would be kept, and the next one need not lie there.
        store.collect(None).unwrap();
        // The whole bundle, a list as long as any may be, and a byte behind each end.
        let most = limits::STATEMENTS + limits::SEAL + limits::CONTENTS + 100_000;
        assert!(stall.read.get() <= most, "{kind} made the unit read {} bytes: {refused}", stall.read.get());
        let names = disk.tree("generations").unwrap();
        assert!(names.keys().all(|name| name.starts_with("1/")), "{kind} left {names:?}");
        assert_eq!(disk.tree(CURRENT).as_ref(), Some(&played.files), "{kind}");
        let stored = disk.tree("objects").unwrap();
        assert!(stored.iter().all(|(name, bytes)| ObjectId::of(bytes).path() == format!("objects/{name}")), "{kind}");
    }
    assert!(reasons.len() == 18 && reasons.values().all(|count| *count >= 600), "{reasons:?}");
    attempt(&mut store, &mut genuine.stall.clone()).unwrap();
    assert_eq!(disk.tree(CURRENT), Some(genuine.files));
}

/// Forgery number `number`, and what kind it is.
fn forge(number: u64, genuine: &Good, others: &Good, played: &Good, random: &mut ChaCha8Rng) -> (&'static str, Stall) {
    let mut stall = genuine.stall.clone();
    stall.read = Rc::default();
    let kind = match number % 2 {
        0 => damage(number / 2 % 9, &mut stall, genuine, others, random),
        _ if number / 2 % 9 == 8 => replay(&mut stall, played),
        _ => deceit(number / 2 % 9, &mut stall, genuine, others, random),
    };
    (kind, stall)
}

/// Something is done to the bytes of one of the files that the unit would read.
fn damage(which: u64, stall: &mut Stall, genuine: &Good, others: &Good, random: &mut ChaCha8Rng) -> &'static str {
    let list = genuine.bundle.seal().letter().contents.path();
    // Of the content, the unit lacks this.
    let fresh = ObjectId::of(&genuine.files["loops/0.mp4"]).path();
    let target = [seal_path("lobby"), list, fresh][(random.next_u32() % 3) as usize].clone();
    let size = stall.wares[&target].len();
    let at = random.next_u32() as usize % size;
    let ware = stall.wares.get_mut(&target).unwrap();
    match which {
        0 => {
            ware[at] ^= 1 << (random.next_u32() % 8);
            "a flipped bit"
        }
        1 => {
            ware.truncate(at);
            "cut short"
        }
        2 => {
            ware.insert(at, random.next_u32() as u8);
            "a byte more"
        }
        3 => {
            ware.remove(at);
            "a byte less"
        }
        4 => {
            let length = (random.next_u32() as usize % 200).min(size - at).max(1);
            let before = ware.clone();
            random.fill_bytes(&mut ware[at..at + length]);
            ware[at] ^= u8::from(*ware == before);
            "rubbish inside"
        }
        5 => {
            let other = others.stall.wares.values().nth(random.next_u32() as usize % others.stall.wares.len()).unwrap();
            assert_ne!(ware, other);
            ware.clone_from(other);
            "another bundle's file"
        }
        6 => {
            stall.wares.remove(&target);
            "a missing file"
        }
        7 => {
            let mut paths: Vec<String> = stall.wares.keys().filter(|path| **path != target).cloned().collect();
            let other = paths.swap_remove(random.next_u32() as usize % paths.len());
            let (one, two) = (stall.wares[&target].clone(), stall.wares[&other].clone());
            assert_ne!(one, two);
            stall.wares.extend([(target, two), (other, one)]);
            "two files swapped"
        }
        _ => {
            stall.is_endless = true;
            "a source without end"
        }
    }
}

/// The very bundle that the unit has played.
fn replay(stall: &mut Stall, played: &Good) -> &'static str {
    stall.wares.clone_from(&played.stall.wares);
    "the bundle of before"
}

/// Somebody wrote a bundle: a stranger, or even the artist.
fn deceit(which: u64, stall: &mut Stall, genuine: &Good, others: &Good, random: &mut ChaCha8Rng) -> &'static str {
    match which {
        0 => {
            stall.wares.extend(others.stall.wares.clone());
            stall.wares.insert(seal_path("lobby"), others.bundle.seal().bytes().to_vec());
            "another unit's bundle"
        }
        1 => {
            resealed(stall, genuine, 1 + u64::from(random.next_u32()) % 5, "artist");
            "an older sequence"
        }
        2 => {
            resealed(stall, genuine, 6 + u64::from(random.next_u32()), "stranger");
            "an unknown key"
        }
        3 => {
            resealed(stall, genuine, 6 + u64::from(random.next_u32()), "spare");
            "a revoked key"
        }
        4 => {
            stall.wares.insert(STATEMENTS.to_owned(), lies(random));
            resealed(stall, genuine, 6 + u64::from(random.next_u32()), "stranger");
            "a key that vouches for itself"
        }
        5 => {
            listing(stall, genuine, &tricky(random));
            "a path that leads astray"
        }
        6 => {
            huge(stall, genuine, random);
            "huge counts"
        }
        _ => {
            let seal = genuine.bundle.seal().bytes();
            let ends: Vec<usize> = (0..seal.len()).filter(|at| seal[*at] == b'\n').collect();
            let (signature, text) = seal.split_at(ends[3] + 1);
            let newer = format!("sequence {}", 7 + random.next_u32());
            let text = String::from_utf8(text.to_vec()).unwrap().replace("sequence 6", &newer);
            stall.wares.insert(seal_path("lobby"), [signature, text.as_bytes()].concat());
            "another text under a good signature"
        }
    }
}

/// The genuine bundle with another sequence, signed by `who`.
fn resealed(stall: &mut Stall, genuine: &Good, sequence: u64, who: &'static str) {
    let letter = SealBody { sequence: Sequence(sequence), ..genuine.bundle.seal().letter().clone() };
    stall.wares.insert(seal_path("lobby"), letter.sign(key(who)).unwrap());
}

/// A list of files that the artist has signed, whatever it says.
fn listing(stall: &mut Stall, genuine: &Good, list: &str) {
    let letter = SealBody {
        contents: ObjectId::of(list.as_bytes()),
        contents_size: (list.len() as u64).min(limits::CONTENTS),
        sequence: Sequence(100),
        ..genuine.bundle.seal().letter().clone()
    };
    stall.wares.insert(letter.contents.path(), list.as_bytes().to_vec());
    stall.wares.insert(seal_path("lobby"), letter.sign(key("artist")).unwrap());
}

fn lies(random: &mut ChaCha8Rng) -> Vec<u8> {
    let (stranger, spare, artist) = (key("stranger"), key("spare"), key("artist"));
    let word = Statement::Trust(stranger.public());
    match random.next_u32() % 4 {
        0 => word.sign(stranger).unwrap(),
        1 => word.sign(spare).unwrap(),
        2 => [Statement::Revoke(artist.public().id()).sign(stranger).unwrap(), word.sign(stranger).unwrap()].concat(),
        _ => {
            let mut good = Statement::Trust(spare.public()).sign(artist).unwrap();
            let at = good.len() - 20;
            good[at] ^= 1;
            good
        }
    }
}

/// A good list of files, with one line that no unit may follow.
fn tricky(random: &mut ChaCha8Rng) -> String {
    let long = "x".repeat(limits::PATH + 1);
    let (trick, id) = (random.next_u32() as usize, ObjectId::of(b"trick"));
    let path = ASTRAY.get(trick % (ASTRAY.len() + 1)).copied().unwrap_or(&long);
    let toml = flock(1, 0)["flock.toml"].clone();
    let clip = flock(1, 0)["loops/0.mp4"].clone();
    let mut lines = [
        format!("{id} 5 {path}"),
        format!("{} {} flock.toml", ObjectId::of(&toml), toml.len()),
        format!("{} {} loops/0.mp4", ObjectId::of(&clip), clip.len()),
    ];
    lines.sort_by_key(|line| line.splitn(3, ' ').nth(2).map(str::to_owned));
    format!("dreams contents 1\n{}\n", lines.join("\n"))
}

/// More of something than there may be.
fn huge(stall: &mut Stall, genuine: &Good, random: &mut ChaCha8Rng) {
    let id = ObjectId::of(b"huge");
    let line = |size: &str, at: usize| format!("{id} {size} {at:08}\n");
    let heading = "dreams contents 1\n";
    match random.next_u32() % 6 {
        0 => listing(stall, genuine, &format!("{heading}{}", line("18446744073709551615", 0))),
        1 => listing(stall, genuine, &format!("{heading}{}", line("99999999999999999999999", 0))),
        2 => listing(stall, genuine, &format!("{heading}{id} 68719476736 00000000\n").repeat(100)),
        3 => {
            let big: Vec<String> = (0..70).map(|at| line("68719476736", at)).collect();
            listing(stall, genuine, &format!("{heading}{}", big.concat()));
        }
        4 => {
            let line = "\u{1f411}".repeat(1000);
            listing(stall, genuine, &format!("{heading}{id} 5 {line}\n"));
        }
        _ => {
            let mut seal = genuine.bundle.seal().bytes().to_vec();
            seal.resize(limits::SEAL as usize + 1, b'\n');
            stall.wares.insert(seal_path("lobby"), seal);
        }
    }
}

#[test]
fn a_list_at_its_limits_is_read_and_one_beyond_is_refused() {
    let genuine = good(1, 6, &["lobby"]);
    let list = |files: &[(&str, u64)]| {
        let line = |(path, size): &(&str, u64)| format!("{} {size} {path}\n", ObjectId::of(path.as_bytes()));
        format!("dreams contents 1\n{}", files.iter().map(line).collect::<String>())
    };
    let refusal = |list: &str| {
        let mut stall = genuine.stall.clone();
        listing(&mut stall, &genuine, list);
        let mut tried = None;
        let memory = allocation_counter::measure(|| tried = verify(&mut stall).err().map(|error| error.to_string()));
        assert!(memory.bytes_max <= MEMORY, "a list of {} bytes took {} of memory", list.len(), memory.bytes_max);
        tried
    };
    let names: Vec<String> = (0..limits::FILES).map(|at| format!("a/{at:06}")).collect();
    let files = |count: usize, size, toml| {
        let files = names[..count].iter().map(|name| (name.as_str(), size));
        list(&files.chain([("flock.toml", toml)]).collect::<Vec<_>>())
    };
    let largest = usize::try_from(limits::TOTAL / limits::FILE).unwrap();
    let (toml, object) = (limits::FLOCK_TOML, ObjectId::of(names[0].as_bytes()));
    for (fits, beyond, words) in [
        (files(limits::FILES - 1, 1, 1), files(limits::FILES, 1, 1), format!("has more than {} files", limits::FILES)),
        (files(1, 1, toml), files(1, 1, toml + 1), format!("`flock.toml` of the bundle is larger than {toml} bytes")),
        (
            files(1, limits::FILE, 1),
            files(1, limits::FILE + 1, 1),
            format!("object {object} of the bundle is larger than {} bytes", limits::FILE),
        ),
        (
            files(largest, limits::FILE, 0),
            files(largest, limits::FILE, 1),
            format!("the list of files of the bundle is larger than {} bytes", limits::TOTAL),
        ),
    ] {
        assert_eq!(refusal(&fits), None, "{words}");
        let refused = refusal(&beyond).unwrap_or_else(|| panic!("not refused: {words}"));
        assert!(refused.ends_with(&words), "{refused}");
    }
    // What is longer itself is neither made nor signed.
    let length = limits::CONTENTS as usize / limits::FILES;
    let entry = |at: usize| FileEntry {
        path: FilePath::new(&if at == 0 { "flock.toml".to_owned() } else { format!("{at:0length$}") }).unwrap(),
        id: ObjectId::of(&at.to_le_bytes()),
        size: 1,
    };
    let made = Contents::new((0..limits::FILES).map(entry).collect()).unwrap_err();
    let letter = SealBody { contents_size: limits::CONTENTS + 1, ..genuine.bundle.seal().letter().clone() };
    let Err(SignError::Refused(signed)) = letter.sign(key("artist")) else { panic!("it was signed") };
    for refused in [made, signed] {
        assert!(matches!(refused, Refusal::TooLarge { part: Part::Contents, limit: limits::CONTENTS }), "{refused}");
    }
}

#[test]
fn a_list_that_is_longer_or_shorter_than_its_seal_says_is_refused_whoever_signed_both() {
    let genuine = good(1, 6, &["lobby"]);
    let list = genuine.bundle.contents_bytes().to_vec();
    let size = list.len() as u64;
    for (signed, read, how) in
        [(size - 1, size, "longer"), (size / 2, size / 2 + 1, "longer"), (size + 1, size, "shorter")]
    {
        let mut stall = genuine.stall.clone();
        let letter = SealBody { contents_size: signed, ..genuine.bundle.seal().letter().clone() };
        stall.wares.insert(seal_path("lobby"), letter.sign(key("artist")).unwrap());
        let told = format!(
            "the list of files of the bundle is {how} than its seal says: expected {signed} bytes, read {read}"
        );
        assert_eq!(verify(&mut stall).unwrap_err().to_string(), told);
        // The same where the whole list is at hand, as in a store.
        let seal = UnverifiedSeal::open(&mut stall, &unit("lobby")).unwrap().verify(&trust()).unwrap();
        assert!(matches!(
            seal.open(list.clone()),
            Err(Refusal::Length { expected, found, .. }) if (expected, found) == (signed, size)
        ));
    }
}

fn verify(stall: &mut Stall) -> Result<VerifiedBundle, Refusal> {
    UnverifiedSeal::open(stall, &unit("lobby"))?.verify(&trust())?.fetch(stall)
}

#[test]
fn what_is_on_a_stick_is_read_through_no_link_and_from_no_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let files = flock(2, 0);
    press(folder.path(), &files, &[], 1, "artist");
    assert!(verified(folder.path(), &trust()).is_ok());
    let seal = folder.path().join("seals/all.seal");
    let elsewhere = tempfile::tempdir().unwrap();
    std::fs::rename(&seal, elsewhere.path().join("seal")).unwrap();
    std::os::unix::fs::symlink(elsewhere.path().join("seal"), &seal).unwrap();
    assert!(verified(folder.path(), &trust()).unwrap_err().is_io());
    std::fs::remove_file(&seal).unwrap();
    rustix::fs::mkfifoat(rustix::fs::CWD, &seal, rustix::fs::Mode::RUSR).unwrap();
    assert!(verified(folder.path(), &trust()).unwrap_err().is_io());
}

impl Stall {
    fn ware(&self, path: &str) -> io::Result<Box<dyn Read>> {
        let bytes = self.wares.get(path).cloned().ok_or(io::ErrorKind::NotFound)?;
        let ware = io::Cursor::new(bytes);
        let reader: Box<dyn Read> =
            if self.is_endless { Box::new(ware.chain(io::repeat(b'\n'))) } else { Box::new(ware) };
        Ok(Box::new(Counted(reader, Rc::clone(&self.read))))
    }
}

impl Source for Stall {
    fn small(&mut self, path: &str, _limit: u64) -> io::Result<Box<dyn Read + '_>> {
        self.ware(path)
    }

    fn object(&mut self, id: &ObjectId, _size: u64, from: u64) -> io::Result<Box<dyn Read + '_>> {
        let mut reader = self.ware(&id.path())?;
        io::copy(&mut reader.by_ref().take(from), &mut io::sink())?;
        Ok(reader)
    }
}

impl Read for Counted {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.0.read(buffer)?;
        self.1.set(self.1.get() + count as u64);
        Ok(count)
    }
}
