//! Which device of the kernel leads to the display at a connector.
//!
//! Owns the search: the I2C bus that belongs to the connector itself, never another bus of the machine; and the CEC adapter
//! that names the connector, or the only one that names none.
//!
//! Start at [`i2c_bus`] and [`cec_adapter`].

use crate::raw::cec_connector;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

/// How the names of I2C buses begin.
const BUS: &str = "i2c-";
/// CEC adapters that are looked at, at most: the kernel's own limit is higher than any machine has.
const ADAPTERS: u32 = 16;
/// The type of a connector of a DRM card, in what an adapter says.
const OF_DRM: u32 = 1;

/// The node in `dev` of the I2C bus of the connector `folder`, as `card0-HDMI-A-1`; `None` if it has none. That of a
/// DP connector is a part of its AUX channel.
pub(super) fn i2c_bus(sys: &Path, dev: &Path, folder: &str) -> Option<PathBuf> {
    let connector = sys.join("class/drm").join(folder);
    let linked = connector.join("ddc").canonicalize().ok().and_then(|bus| bus_name(&bus));
    let below = || fs::read_dir(&connector).ok()?.flatten().find_map(|entry| bus_name(&entry.path()));
    linked.or_else(below).map(|name| dev.join(name))
}

/// The name of the I2C bus at `path`; `None` if it is none.
fn bus_name(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    let number = name.strip_prefix(BUS)?;
    (!number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())).then(|| name.to_owned())
}

/// The open CEC adapter of the connector `folder`; `None` if there is none that may be opened.
pub(super) fn cec_adapter(sys: &Path, dev: &Path, folder: &str) -> Option<File> {
    let connector = sys.join("class/drm").join(folder);
    let number = |text: &str| text.trim().parse::<u32>().ok();
    let card = number(folder.strip_prefix("card")?.split_once('-')?.0)?;
    let id = fs::read_to_string(connector.join("connector_id")).ok().and_then(|text| number(&text));
    let open = |number| File::options().read(true).write(true).open(dev.join(format!("cec{number}"))).ok();
    let mut adapters: Vec<File> = (0..ADAPTERS).filter_map(open).collect();
    let reported: Vec<_> =
        adapters.iter().map(|adapter| cec_connector(adapter).ok().and_then(|reported| place(&reported))).collect();
    chosen(&reported, card, id).map(|at| adapters.swap_remove(at))
}

/// The number of the card and of the connector that an adapter says; `None` if it says none.
fn place(reported: &[u32]) -> Option<(u32, u32)> {
    (reported[0] == OF_DRM).then_some((reported[1], reported[2]))
}

/// Which of the adapters belongs to connector `id` of `card`, or, where the kernel does not say the `id`, to the card; else
/// the only one that says nothing.
fn chosen(reported: &[Option<(u32, u32)>], card: u32, id: Option<u32>) -> Option<usize> {
    let is_here = |(of, at): (u32, u32)| of == card && id.is_none_or(|id| id == at);
    let here = (0..reported.len()).filter(|at| reported[*at].is_some_and(is_here));
    only(here).or_else(|| only((0..reported.len()).filter(|at| reported[*at].is_none())))
}

/// The only one of `found`; `None` if there are none, or several.
fn only(mut found: impl Iterator<Item = usize>) -> Option<usize> {
    found.next().filter(|_| found.next().is_none())
}

#[cfg(test)]
mod tests {
    use super::{chosen, i2c_bus, place};
    use std::fs;
    use std::os::unix::fs::symlink;
    use std::path::Path;

    #[test]
    fn only_the_bus_of_the_connector_itself_is_used() {
        let sys = tempfile::tempdir().unwrap();
        let at = |path: &str| sys.path().join(path);
        for folder in [
            "devices/gpu/i2c-3",
            "devices/smbus/i2c-0",
            "class/drm/card0-HDMI-A-1",
            "class/drm/card0-DP-1/i2c-7/i2c-dev",
            "class/drm/card0-DP-2/i2c-dev",
            "class/drm/card0-eDP-1/i2c-",
        ] {
            fs::create_dir_all(at(folder)).unwrap();
        }
        symlink(at("devices/gpu/i2c-3"), at("class/drm/card0-HDMI-A-1/ddc")).unwrap();
        symlink(at("devices/smbus"), at("class/drm/card0-DP-2/ddc")).unwrap();
        let bus = |folder: &str| i2c_bus(sys.path(), Path::new("/dev"), folder);
        let found = ["card0-HDMI-A-1", "card0-DP-1", "card0-DP-2", "card0-eDP-1", "card1-DP-1"].map(bus);
        let wanted = [Some("/dev/i2c-3".into()), Some("/dev/i2c-7".into()), None, None, None];
        assert_eq!(found, wanted);
    }

    #[test]
    fn an_adapter_of_another_connector_is_never_used() {
        let [mine, other, card] = [Some((0, 92)), Some((0, 95)), Some((1, 92))];
        assert_eq!(chosen(&[other, mine, card], 0, Some(92)), Some(1));
        assert_eq!(chosen(&[other, card], 0, Some(92)), None);
        assert_eq!(chosen(&[other, None], 0, Some(92)), Some(1), "an adapter on USB says nothing");
        assert_eq!(chosen(&[None, None], 0, Some(92)), None, "nobody knows which");
        assert_eq!((chosen(&[mine, card], 0, None), chosen(&[mine, other], 0, None)), (Some(0), None));
        assert_eq!((place(&[1, 0, 92]), place(&[0, 7, 7])), (Some((0, 92)), None));
    }
}
