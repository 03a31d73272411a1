//! A notice over the picture, for the people in front of it.
//!
//! Owns the drawing: a dark pane at the bottom left with light letters, and a progress bar beneath. It never covers more
//! than a twentieth of the picture. On a dimmed display the frames are dimmed, and it is not: `presenter/display.rs`. The text
//! comes from the updater and `dreams-owner`; `notice_watcher.rs` decides how long it is shown.
//!
//! Start at [`NoticePane::draw`].

use crate::control::pane::Pane;
use font8x8::legacy::BASIC_LEGACY;
use player::Notice;

/// Dots of a letter, across and down.
const LETTER: u32 = 8;
/// Rows of the picture, or columns if there are fewer, for each pixel of a dot.
const ROWS_PER_DOT: u32 = 360;
/// Letters of the longest line, at least.
const SHORTEST: usize = 20;
/// Luma of the pane and of the letters: calm, and legible.
const PANE: u8 = 30;
const INK: u8 = 190;
/// Luma of the rest of the progress bar.
const DIM: u8 = 70;

/// The drawing of a notice.
#[derive(Debug)]
pub(crate) struct NoticePane(Pane);

impl NoticePane {
    /// Draws `notice` for pictures of this size, in the largest letters, and then in the longest lines, in which all of it
    /// covers little enough. If none do, it is cut; `None` if the picture is too small.
    pub(crate) fn draw(notice: &Notice, size: (u32, u32)) -> Option<Pane> {
        let largest = (size.0.min(size.1) / ROWS_PER_DOT).max(1);
        let all = letters(&notice.lines(Notice::LINE));
        let dots = || (1..=largest).rev();
        let whole = |dot| (SHORTEST..=Notice::LINE).rev().find_map(|line| Self::with(notice, size, dot, line, all));
        let cut = || dots().find_map(|dot| Self::with(notice, size, dot, Notice::LINE, 0));
        dots().find_map(whole).or_else(cut).map(|drawn| drawn.0)
    }

    /// The same, with dots of so many pixels, lines of at most `line` letters, and at least `least` letters in all.
    fn with(notice: &Notice, (width, height): (u32, u32), dot: u32, line: usize, least: usize) -> Option<Self> {
        let (pitch, margin) = (LETTER * dot, LETTER * dot / 2);
        let room = (width.saturating_sub(6 * margin) / pitch) as usize;
        let lines = notice.lines(room.min(line));
        if letters(&lines) < least {
            return None;
        }
        let across = lines.iter().map(String::len).max().filter(|across| *across > 0)? as u32;
        let bar = if notice.thousandths.is_some() { 3 * dot } else { 0 };
        let down = lines.len() as u32 * (pitch + 2 * dot) + bar;
        let size = (across * pitch + 2 * margin, (down + 2 * margin + 1) & !1);
        let fits = size.0 + 4 * margin <= width && size.1 + 4 * margin <= height;
        let covered = u64::from(size.0) * u64::from(size.1) * 20;
        if !fits || covered > u64::from(width) * u64::from(height) {
            return None;
        }
        let at = (2 * margin, (height - size.1 - 2 * margin) & !1);
        let mut pane = Self(Pane { picture: (width, height), at, size, luma: vec![PANE; (size.0 * size.1) as usize] });
        for (row, line) in lines.iter().enumerate() {
            for (column, letter) in line.bytes().enumerate() {
                let left = margin + column as u32 * pitch;
                pane.letter(letter, (left, margin + row as u32 * (pitch + 2 * dot)), dot);
            }
        }
        if let Some(thousandths) = notice.thousandths {
            let (top, length) = (size.1 - margin - dot, size.0 - 2 * margin);
            let done = length * u32::from(thousandths.min(1_000)) / 1_000;
            pane.fill((margin, top), (length, dot), DIM);
            pane.fill((margin, top), (done, dot), INK);
        }
        Some(pane)
    }

    fn letter(&mut self, letter: u8, (left, top): (u32, u32), dot: u32) {
        for (y, row) in BASIC_LEGACY[usize::from(letter)].into_iter().enumerate() {
            for x in (0..LETTER).filter(|x| row & 1 << x != 0) {
                self.fill((left + x * dot, top + y as u32 * dot), (dot, dot), INK);
            }
        }
    }

    fn fill(&mut self, (left, top): (u32, u32), (across, down): (u32, u32), luma: u8) {
        for y in top..top + down {
            let row = (y * self.0.size.0 + left) as usize;
            self.0.luma[row..row + across as usize].fill(luma);
        }
    }
}

/// How many letters these lines have, without spaces.
fn letters(lines: &[String]) -> usize {
    lines.iter().flat_map(|line| line.split(' ')).map(str::len).sum()
}

#[cfg(test)]
mod tests {
    use super::{DIM, INK, NoticePane, PANE};
    use crate::control::pane::{FULL, Overlay, PaneBuffer};
    use player::Notice;
    use screen::Picture;
    use std::sync::Arc;

    fn notice(text: &str, thousandths: Option<u16>) -> Notice {
        Notice { text: text.to_owned(), thousandths }
    }

    #[test]
    fn a_notice_covers_a_twentieth_at_most_and_leaves_the_rest_as_it_is() {
        let longest = "This flock is not signed by anybody whom this frame trusts.";
        for (width, height) in [(640u32, 480u32), (1280, 720), (1920, 1080), (3840, 2160), (720, 1280)] {
            let pane = NoticePane::draw(&notice(longest, Some(500)), (width, height)).unwrap();
            let ground: Vec<u8> = (0..width * height).map(|at| (at % 200) as u8 + 40).collect();
            let colour = vec![77; (width * height / 4) as usize];
            let (wide, half) = (width as usize, width as usize / 2);
            let picture = Picture { width, height, planes: [&ground, &colour, &colour], strides: [wide, half, half] };
            let (overlay, mut memory) = (Overlay::default(), PaneBuffer::default());
            overlay.set_notice(Some(Arc::new(pane)));
            let over = overlay.get().over(&picture, FULL, &mut memory);
            let changed = over.planes[0].iter().zip(&ground).filter(|(over, ground)| over != ground).count();
            assert!(changed * 20 <= ground.len() && changed * 100 > ground.len(), "{changed} of {width}x{height}");
            let grey = over.planes[1].iter().filter(|sample| **sample != 77).count();
            assert!(grey * 20 <= colour.len() && grey > 0);
            assert_eq!(over.planes[0][..wide * 100], ground[..wide * 100], "the top is the picture's");
        }
    }

    #[test]
    fn a_notice_over_dimmed_frames_is_as_bright_as_over_others() {
        let pane = NoticePane::draw(&notice("Here.", None), (640, 480)).unwrap();
        let (luma, chroma) = (vec![116; 640 * 480], vec![228; 320 * 240]);
        let picture = Picture { width: 640, height: 480, planes: [&luma, &chroma, &chroma], strides: [640, 320, 320] };
        let (overlay, mut memory) = (Overlay::default(), PaneBuffer::default());
        overlay.set_notice(Some(Arc::new(pane.clone())));
        let over = overlay.get().over(&picture, 400, &mut memory);
        let rows = over.planes[0].chunks(640).skip(pane.at.1 as usize).take(pane.size.1 as usize);
        let there: Vec<u8> = rows.flat_map(|row| row[pane.at.0 as usize..][..pane.size.0 as usize].to_vec()).collect();
        assert!(there == pane.luma && there.contains(&INK), "no letter is darker");
        assert_eq!((over.planes[0][0], over.planes[1][0]), (57, 169), "the frame has 4 tenths of its light and colour");
    }

    #[test]
    fn three_lines_have_large_letters_on_the_framed_display_too() {
        let text = vec!["w".repeat(Notice::LARGE_LINE); Notice::LINES].join(" ");
        let pane = NoticePane::draw(&notice(&text, None), (1280, 720)).unwrap();
        assert_eq!(pane.size.1, 3 * (8 + 2) * 2 + 16, "three lines of dots of two pixels");
        assert!(pane.size.0 * pane.size.1 * 20 <= 1280 * 720);
    }

    #[test]
    fn a_letter_is_drawn_as_it_is_and_progress_as_a_line() {
        let lit = |thousandths| {
            let pane = NoticePane::draw(&notice("I", thousandths), (640, 480)).unwrap();
            (pane.luma.iter().filter(|luma| **luma > DIM).count(), pane.luma.len())
        };
        let (letter, all) = lit(None);
        assert!(letter > 10 && letter * 4 < all);
        assert!(lit(Some(0)).0 == letter && lit(Some(1_000)).0 == letter + 8 && lit(Some(9_999)).0 == letter + 8);
    }

    #[test]
    fn a_picture_too_small_for_a_word_has_no_notice_and_one_of_another_size_stays() {
        assert_eq!(NoticePane::draw(&notice("A new flock is coming in.", None), (64, 48)), None);
        assert_eq!(NoticePane::draw(&notice("", None), (640, 480)), None);
        let pane = NoticePane::draw(&notice("Here.", None), (1280, 720)).unwrap();
        let (luma, chroma) = ([9; 256], [128; 64]);
        let small = Picture { width: 16, height: 16, planes: [&luma, &chroma, &chroma], strides: [16, 8, 8] };
        assert!(pane.luma.contains(&PANE));
        let overlay = Overlay::default();
        overlay.set_notice(Some(Arc::new(pane)));
        assert_eq!(overlay.get().over(&small, FULL, &mut PaneBuffer::default()).planes[0], luma);
    }
}
