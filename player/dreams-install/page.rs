//! What is shown: a page of text with a bar for the progress, in the look of a unit's notices.
//!
//! Owns the words of each state, and their drawing in large letters. A disk's name and size are on every page on which a key
//! may write to it. Never decides anything.
//!
//! Start at [`Page::of`].

use crate::conversation::{State, Trouble, fitting};
use crate::copying::Phase;
use crate::disks::{Disk, Fitness};
use font8x8::legacy::BASIC_LEGACY;
use screen::Picture;

/// The size that a page is drawn in: the screen scales it.
pub(crate) const SIZE: (u32, u32) = (1_280, 720);
/// Dots of a letter, across and down.
const LETTER: usize = 8;
/// Pixels of a dot: of the title, and of the rest.
const TITLE: usize = 5;
const TEXT: usize = 3;
/// Pixels at the left and above, and between two lines.
const MARGIN: usize = 64;
const GAP: usize = 14;
/// Letters of a line.
const LINE: usize = (SIZE.0 as usize - 2 * MARGIN) / (LETTER * TEXT);
/// Luma, as of a notice.
const GROUND: u8 = 30;
const INK: u8 = 190;
const DIM: u8 = 70;
const GREY: u8 = 128;
/// Disks that are named where none fits, at most.
const MOST: usize = 4;
/// Bytes of a gigabyte and of a megabyte, as makers of disks count.
const GB: u64 = 1_000_000_000;
const MB: u64 = 1_000_000;

const SWITCH_OFF: &str = "Switch off to leave everything as it is.";
const LOST: &str = "Everything on this disk will be lost.";

/// A page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Page {
    pub(crate) title: &'static str,
    /// Paragraphs, of ASCII; a line break within one is kept.
    pub(crate) text: Vec<String>,
    pub(crate) thousandths: Option<u16>,
}

impl Page {
    /// The page of a state. `needed` is how many bytes a disk must have.
    pub(crate) fn of(state: &State, needed: u64) -> Self {
        let page = |title, text: Vec<String>| Self { title, text, thousandths: None };
        let own = str::to_owned;
        match state {
            State::Looking => page("One moment", vec![own("Looking for disks.")]),
            State::NoDisk { disks } => {
                let needed_mb = needed.div_ceil(MB);
                let none = format!("This computer has no disk for the picture: it needs {needed_mb} MB.");
                let others = disks.iter().take(MOST).map(|disk| unfit(disk, needed));
                page("No disk", [none].into_iter().chain(others).chain([own(SWITCH_OFF)]).collect())
            }
            State::Choose { disks } => {
                let line = |(at, disk): (usize, &&Disk)| format!("{}  {}", at + 1, named(disk));
                let lines: Vec<_> = fitting(disks).iter().enumerate().map(line).collect();
                let ask = own("Press the number of the disk that the picture is installed on. Nothing is written yet.");
                page("Which disk?", vec![ask, lines.join("\n"), own(SWITCH_OFF)])
            }
            State::Confirm { disk, stay, .. } => page("Install the picture", confirm(disk, *stay)),
            State::Working { disk, phase, thousandths } => {
                let doing = match phase {
                    Phase::Check => "Step 1 of 3: checking the stick. Nothing is written yet.",
                    Phase::Write => "Step 2 of 3: writing.",
                    Phase::Compare => "Step 3 of 3: comparing what was written.",
                };
                let text = vec![named(disk), own(doing), own("Leave the stick in, and the computer on.")];
                Self { thousandths: Some(*thousandths), ..page("Installing", text) }
            }
            State::Failed { disk, trouble } => page(
                "Not installed",
                vec![named(disk), own(failure(*trouble)), own("Press Enter to begin again, or switch off.")],
            ),
            State::Installed => page("Installed", vec![own("Remove the stick; the picture starts.")]),
        }
    }

    /// The lines of the text, as they are drawn; an empty one after each paragraph but the last.
    pub(crate) fn lines(&self) -> Vec<String> {
        let paragraphs: Vec<_> = self.text.iter().map(|text| broken(text)).collect();
        paragraphs.join(&String::new())
    }

    /// The drawing.
    pub(crate) fn draw(&self) -> Drawing {
        let mut drawing = Drawing::blank();
        drawing.write(self.title, MARGIN, TITLE);
        let mut top = MARGIN + LETTER * TITLE + 3 * GAP;
        for line in self.lines() {
            drawing.write(&line, top, TEXT);
            top += if line.is_empty() { LETTER * TEXT } else { LETTER * TEXT + GAP };
        }
        if let Some(thousandths) = self.thousandths {
            let across = SIZE.0 as usize - 2 * MARGIN;
            let top = SIZE.1 as usize - 2 * MARGIN;
            drawing.fill((MARGIN, top), (across, LETTER * TEXT), DIM);
            drawing.fill((MARGIN, top), (across * usize::from(thousandths.min(1_000)) / 1_000, LETTER * TEXT), INK);
        }
        drawing
    }
}

/// A drawn page, without colour.
#[derive(Debug)]
pub(crate) struct Drawing {
    luma: Vec<u8>,
    chroma: Vec<u8>,
}

impl Drawing {
    fn blank() -> Self {
        let pixels = (SIZE.0 * SIZE.1) as usize;
        Self { luma: vec![GROUND; pixels], chroma: vec![GREY; pixels / 4] }
    }

    /// As a screen takes it.
    pub(crate) fn picture(&self) -> Picture<'_> {
        let (width, height) = SIZE;
        let (across, half) = (width as usize, width as usize / 2);
        let planes = [&self.luma[..], &self.chroma[..], &self.chroma[..]];
        Picture { width, height, planes, strides: [across, half, half] }
    }

    /// Writes a line; what does not fit is left out.
    fn write(&mut self, line: &str, top: usize, dot: usize) {
        for (column, letter) in line.bytes().enumerate() {
            let left = MARGIN + column * LETTER * dot;
            let rows = BASIC_LEGACY.get(usize::from(letter)).into_iter().flatten();
            for (y, row) in rows.enumerate() {
                for x in (0..LETTER).filter(|x| row & 1 << x != 0) {
                    self.fill((left + x * dot, top + y * dot), (dot, dot), INK);
                }
            }
        }
    }

    fn fill(&mut self, (left, top): (usize, usize), (across, down): (usize, usize), luma: u8) {
        let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
        let (right, bottom) = ((left + across).min(width), (top + down).min(height));
        for y in top.min(bottom)..bottom {
            self.luma[y * width + left.min(right)..y * width + right].fill(luma);
        }
    }
}

fn confirm(disk: &Disk, stay: bool) -> Vec<String> {
    let own = str::to_owned;
    let enter = own("Press Enter to install, or switch off to leave the disk as it is.");
    let (lost, delete) = match (disk.fitness, stay) {
        (Fitness::HasUnit, true) => (
            "There is a picture on this disk already. Its flocks and settings stay.",
            Some("Press Delete first to erase them, too."),
        ),
        (Fitness::HasUnit, false) => (
            "There is a picture on this disk already. Its flocks and settings will be lost.",
            Some("Press Delete again to keep them."),
        ),
        (Fitness::Fits | Fitness::OtherSectors | Fitness::TooSmall, _) => (LOST, None),
    };
    [Some(named(disk)), Some(own(lost)), delete.map(own), Some(enter)].into_iter().flatten().collect()
}

/// What a person calls the disk: model, size, and the kernel's name.
fn named(disk: &Disk) -> String {
    let model = if disk.model.is_empty() { "Disk" } else { &disk.model };
    format!("{model}, {} ({})", size(disk.bytes), disk.name)
}

fn unfit(disk: &Disk, needed: u64) -> String {
    match disk.fitness {
        Fitness::TooSmall => {
            let lacking_mb = needed.saturating_sub(disk.bytes).div_ceil(MB);
            format!("{}: too small, by {lacking_mb} MB.", named(disk))
        }
        Fitness::OtherSectors => format!("{}: its sectors are larger than 512 bytes.", named(disk)),
        Fitness::Fits | Fitness::HasUnit => named(disk),
    }
}

fn failure(trouble: Trouble) -> &'static str {
    match trouble {
        Trouble::Busy => "This disk is in use, or was exchanged. Nothing was written.",
        Trouble::Differs => "The disk does not keep what is written to it. It may be failing: try another one.",
        Trouble::Disk => "The disk cannot be written. It may be failing, or write-protected: try another one.",
        Trouble::Stick => "The stick is damaged. Write the image to it again, or to another one.",
    }
}

/// As makers of disks write it.
fn size(bytes: u64) -> String {
    if bytes >= 10 * GB { format!("{} GB", bytes / GB) } else { format!("{} MB", bytes / MB) }
}

/// The lines of a paragraph, broken where it says so and where they would be too long.
fn broken(text: &str) -> Vec<String> {
    let mut lines = Vec::new();
    for line in text.split('\n') {
        lines.push(String::new());
        for word in line.split(' ') {
            let last = lines.last_mut().expect("one was added above");
            if last.is_empty() {
                last.push_str(word);
            } else if last.len() + 1 + word.len() <= LINE {
                last.push(' ');
                last.push_str(word);
            } else {
                lines.push(word.to_owned());
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::{DIM, Drawing, GROUND, INK, LETTER, LINE, MARGIN, Page, SIZE, TEXT, size};
    use crate::conversation::{State, Trouble};
    use crate::copying::Phase;
    use crate::disks::{Disk, Fitness};

    const NEEDED: u64 = 914_358_272;

    fn disk(name: &str, bytes: u64, fitness: Fitness) -> Disk {
        Disk { name: name.to_owned(), model: "Samsung SSD 980 PRO2".to_owned(), bytes, fitness }
    }

    /// How many pixels have this luma.
    fn pixels(luma: &[u8], wanted: u8) -> usize {
        luma.iter().map(|luma| usize::from(*luma == wanted)).sum()
    }

    fn states() -> Vec<State> {
        let large = disk("nvme0n1", 500_107_862_016, Fitness::Fits);
        let own = disk("mmcblk0", 62_537_072_640, Fitness::HasUnit);
        let small = disk("sda", 512_110_592, Fitness::TooSmall);
        let other = disk("sdb", 4_000_787_030_016, Fitness::OtherSectors);
        let confirm = |disk: &Disk, stay| State::Confirm { disk: disk.clone(), stay, disks: vec![disk.clone()] };
        let failed = |trouble| State::Failed { disk: large.clone(), trouble };
        let working = |phase| State::Working { disk: large.clone(), phase, thousandths: 500 };
        let mut states = vec![
            State::NoDisk { disks: vec![small, other] },
            State::Choose { disks: vec![large.clone(), own.clone()] },
            State::Installed,
            State::Choose { disks: vec![own.clone(); 9] },
        ];
        states.extend([confirm(&large, false), confirm(&own, true), confirm(&own, false)]);
        states.extend([Phase::Check, Phase::Write, Phase::Compare].map(working));
        states.extend([Trouble::Busy, Trouble::Differs, Trouble::Disk, Trouble::Stick].map(failed));
        states
    }

    #[test]
    fn every_page_is_ascii_and_fits_on_the_screen() {
        for state in states() {
            let page = Page::of(&state, NEEDED);
            let lines = page.lines();
            assert!(lines.iter().all(|line| line.len() <= LINE && line.is_ascii()), "{lines:#?}");
            let Drawing { luma, .. } = page.draw();
            let (width, bottom) = (SIZE.0 as usize, (SIZE.1 - 40) as usize);
            assert!(luma[bottom * width..].iter().all(|luma| *luma == GROUND), "its last lines are cut: {lines:#?}");
            let letters: usize = lines.iter().map(String::len).sum();
            assert!(pixels(&luma, INK) > letters * 20, "letters are large");
        }
    }

    #[test]
    fn a_page_on_which_enter_writes_names_the_disk_and_what_is_lost() {
        let [fresh, stays, lost] = [4, 5, 6].map(|at| Page::of(&states()[at], NEEDED).text.join(" "));
        for (text, size, said) in [
            (fresh, "500 GB (nvme0n1)", "Everything on this disk will be lost."),
            (stays, "62 GB (mmcblk0)", "Its flocks and settings stay. Press Delete first to erase them, too."),
            (lost, "62 GB (mmcblk0)", "Its flocks and settings will be lost. Press Delete again to keep them."),
        ] {
            let enter = "Press Enter to install, or switch off to leave the disk as it is.";
            assert!(text.contains("Samsung SSD 980 PRO") && text.contains(size) && text.contains(said), "{text}");
            assert!(text.ends_with(enter), "{text}");
        }
        let small = Page::of(&states()[0], NEEDED).text.join(" ");
        assert!(small.contains("needs 915 MB.") && small.contains("(sda): too small, by 403 MB."), "{small}");
    }

    #[test]
    fn the_bar_is_as_long_as_what_is_done() {
        let page = |thousandths| Page { title: "", text: Vec::new(), thousandths };
        let bright = |thousandths| pixels(&page(thousandths).draw().luma, INK);
        let [none, half, all] = [Some(0), Some(500), Some(1_000)].map(bright);
        let whole = (SIZE.0 as usize - 2 * MARGIN) * LETTER * TEXT;
        assert_eq!((none, half * 2, all, bright(None)), (0, whole, whole, 0));
        assert!(page(Some(0)).draw().luma.contains(&DIM));
        assert_eq!((size(62_537_072_640), size(512_110_592)), ("62 GB".to_owned(), "512 MB".to_owned()));
    }
}
