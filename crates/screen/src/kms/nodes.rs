//! Where the kernel shows its cards: `/dev/dri`, and what `/sys` tells of them.
//!
//! Owns the finding of cards and of the lamp behind a display. Never opens a card.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// Where the connectors of all cards have a folder.
pub(super) const CONNECTORS: &str = "/sys/class/drm";

/// The cards of this machine, the first one first.
pub(super) fn cards() -> io::Result<Vec<PathBuf>> {
    let mut paths: Vec<PathBuf> = fs::read_dir("/dev/dri")?.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("card")));
    paths.sort_by_cached_key(|path| (path.as_os_str().len(), path.clone()));
    Ok(paths)
}

/// Whether the open `card` has a GPU, and so a `renderD*` beside it.
pub(super) fn has_render_node(card: &File) -> bool {
    let Ok(stat) = rustix::fs::fstat(card) else { return false };
    let (major, minor) = (rustix::fs::major(stat.st_rdev), rustix::fs::minor(stat.st_rdev));
    let siblings = fs::read_dir(format!("/sys/dev/char/{major}:{minor}/device/drm"));
    siblings.is_ok_and(|nodes| nodes.flatten().any(|node| node.file_name().to_string_lossy().starts_with("renderD")))
}

/// Has the lamp behind the display at `connector` of `card` shine with so many thousandths of its power, and never go out.
/// `false` if there is none, or we may not set it. `connectors` is [`CONNECTORS`].
pub(super) fn shine(connectors: &Path, card: &Path, connector: &str, thousandths: u16) -> bool {
    let Ok(card) = card.canonicalize() else { return false };
    let Some(card) = card.file_name().and_then(|name| name.to_str()) else { return false };
    let Ok(entries) = fs::read_dir(connectors.join(format!("{card}-{connector}"))) else { return false };
    // The drivers of panels register their lamp below the connector.
    let lamps = entries.flatten().map(|entry| entry.path()).filter(|path| path.join("max_brightness").is_file());
    let lit = lamps.map(|lamp| {
        let most: u64 = fs::read_to_string(lamp.join("max_brightness"))?.trim().parse().map_err(io::Error::other)?;
        let power = (most * u64::from(thousandths.min(1000)) / 1000).max(1);
        fs::write(lamp.join("brightness"), power.to_string())
    });
    let lit: Vec<io::Result<()>> = lit.collect();
    for error in lit.iter().filter_map(|lit| lit.as_ref().err()) {
        tracing::debug!(%error, connector, "the lamp behind the display cannot be set");
    }
    lit.iter().any(Result::is_ok)
}

#[cfg(test)]
mod tests {
    use super::shine;
    use std::fs;

    #[test]
    fn the_lamp_behind_a_display_is_its_own_and_never_goes_out() {
        let folder = tempfile::tempdir().unwrap();
        let card = folder.path().join("card1");
        fs::write(&card, "").unwrap();
        let connectors = folder.path().join("drm");
        for (connector, most) in [("card1-eDP-1", "400\n"), ("card0-eDP-1", "100\n")] {
            let lamp = connectors.join(connector).join("panel_backlight");
            fs::create_dir_all(&lamp).unwrap();
            fs::write(lamp.join("max_brightness"), most).unwrap();
            fs::write(lamp.join("brightness"), "7").unwrap();
        }
        fs::create_dir_all(connectors.join("card1-HDMI-A-1/power")).unwrap();
        let power = |connector: &str| {
            fs::read_to_string(connectors.join(connector).join("panel_backlight/brightness")).unwrap()
        };
        for (thousandths, wanted) in [(1000, "400"), (500, "200"), (1, "1"), (0, "1")] {
            assert!(shine(&connectors, &card, "eDP-1", thousandths));
            assert_eq!((&*power("card1-eDP-1"), &*power("card0-eDP-1")), (wanted, "7"), "{thousandths}");
        }
        assert!(!shine(&connectors, &card, "HDMI-A-1", 500), "it has none");
        assert!(!shine(&connectors, &card, "DP-1", 500), "it is no connector");
        fs::write(connectors.join("card1-eDP-1/panel_backlight/max_brightness"), "many").unwrap();
        assert!(!shine(&connectors, &card, "eDP-1", 500), "it says nothing of use");
    }
}
