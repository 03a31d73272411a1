//! [`Kms`] for the scripted card.
//!
//! Owns the calls of the model in `mod.rs`: how long they take, what they assert. Rejected commits are in `check.rs`.

use super::{
    CLOCK, CONNECTOR, CRTC, Kind, OVERLAY, PRIMARY, PROBE_NS, Pending, Quirk, Scripted, now, oversleep, top_of,
};
use crate::kms::card::{Buffer, BufferSpec, CommitMode, Crtc, Id, Kms, KmsEvent, Properties, Request, Source, Survey};
use crate::paint::Layout;
use drm::control::Mode;
use rustix::io::Errno;
use std::io;
use std::time::Duration;
use timing::{Nanos, Vblank};

impl Kms for Scripted {
    fn name(&self) -> String {
        "/dev/dri/scripted".to_owned()
    }

    fn open(&mut self) -> io::Result<()> {
        let was = std::mem::replace(&mut self.open, true);
        self.usable(false).inspect_err(|_| self.open = was)
    }

    fn close(&mut self) {
        self.open = false;
        if std::mem::take(&mut self.is_gone) {
            self.set_left();
        }
        self.fbs.clear();
        self.blobs.clear();
        self.on_screen = None;
        self.pending = None;
        self.probed_at = None;
        self.asked.clear();
        self.late.clear();
        self.happenings.clear();
        self.values.insert((CRTC, "ACTIVE"), 0);
        self.values.insert((PRIMARY, "FB_ID"), 0);
    }

    fn release_console(&mut self) {
        assert!(!self.open, "the display was left with the card open");
        self.has_released_console = true;
    }

    fn take_master(&mut self) -> io::Result<()> {
        self.usable(true)
    }

    fn survey(&mut self) -> io::Result<Survey> {
        self.usable(false)?;
        oversleep(PROBE_NS);
        let connector = self.connector();
        let properties = |kind, id| self.family.properties(kind, |name| self.value(id, name));
        let crtc = Crtc { id: CRTC, index: 0, mode: self.mode(), properties: properties('c', CRTC) };
        let planes = [(PRIMARY, 'p'), (OVERLAY, 'o')].map(|(id, kind)| self.family.plane(id, properties(kind, id)));
        let planes = planes.into_iter().take(1 + usize::from(self.family.has_overlay)).collect();
        Ok(Survey { driver: self.family.driver.to_owned(), connectors: vec![connector], crtcs: vec![crtc], planes })
    }

    fn probe(&mut self, connector: Id) {
        assert_eq!(connector, CONNECTOR, "another connector was probed");
        if self.usable(false).is_ok() {
            self.probed_at = Some(now().after(PROBE_NS));
        } else {
            self.happenings.push_back(KmsEvent::ProbeFailed(Errno::NODEV));
        }
    }

    fn plane_properties(&mut self, plane: Id) -> io::Result<Properties> {
        self.usable(false)?;
        Ok(self.family.properties('p', |name| self.value(plane, name)))
    }

    fn create(&mut self, spec: BufferSpec) -> io::Result<Vec<Buffer>> {
        self.usable(false)?;
        if self.quirk == Some(Quirk::NoTallFramebuffers) && spec.count > 1 {
            return Err(Errno::INVAL.into());
        }
        let (format, size) = (spec.format.format, (spec.size.0, spec.size.1 * spec.count));
        let limits = &self.family.limits;
        if !limits.formats.contains(&format) || size.0 > limits.largest.0 || size.1 > limits.largest.1 {
            return Err(Errno::INVAL.into());
        }
        let pitch = (format.allocation(size).2 / 8 * size.0).next_multiple_of(limits.pitch);
        let layout = Layout::new(format, size, pitch);
        let fb = self.id();
        self.fbs.insert(fb, vec![0; layout.bytes()]);
        self.layouts.insert(fb, layout);
        let tops = (0..spec.count).map(|nth| nth * spec.size.1);
        Ok(tops.map(|top| Buffer { source: Source { fb, top }, layout: layout.part(top, spec.size.1) }).collect())
    }

    fn destroy(&mut self, fb: Id) {
        assert!(self.on_screen.is_none_or(|source| source.fb != fb), "a framebuffer on the screen was removed");
        assert_ne!(self.value(PRIMARY, "FB_ID"), u64::from(fb.0), "a bound framebuffer was removed");
        assert!(self.fbs.remove(&fb).is_some(), "a framebuffer was removed twice");
    }

    fn write(&mut self, source: Source, paint: &mut dyn FnMut(&mut [u8])) -> io::Result<()> {
        self.pass();
        assert_ne!(self.on_screen, Some(source), "the buffer on the screen was written");
        assert!(self.pending.as_ref().is_none_or(|flip| flip.source != source), "what is committed was written");
        paint(self.fbs.get_mut(&source.fb).expect("a framebuffer that is no more was written"));
        Ok(())
    }

    fn create_mode(&mut self, mode: &Mode) -> io::Result<Id> {
        self.usable(false)?;
        let blob = self.id();
        self.blobs.insert(blob);
        self.made.insert(u64::from(blob.0), *mode);
        Ok(blob)
    }

    fn create_blob(&mut self, bytes: &[u8]) -> io::Result<Id> {
        self.usable(false)?;
        let blob = self.id();
        self.blobs.insert(blob);
        self.blob_bytes.insert(u64::from(blob.0), bytes.to_vec());
        Ok(blob)
    }

    fn find_backlight(&mut self, _: &str) -> bool {
        self.quirk == Some(Quirk::Backlight)
    }

    fn set_backlight(&mut self, thousandths: u16) {
        assert_eq!(self.quirk, Some(Quirk::Backlight), "a backlight that is not there was set");
        self.backlight = thousandths;
    }

    fn destroy_blob(&mut self, blob: Id) {
        assert!(self.blobs.remove(&blob), "a blob was removed twice");
    }

    fn commit(&mut self, how: CommitMode, request: &Request) -> io::Result<()> {
        let wanted = |name: &str| self.wanted(request, name);
        let kind = match how {
            CommitMode::Test => Kind::Test,
            CommitMode::Flip => Kind::Flip,
            CommitMode::Settle | CommitMode::Modeset if wanted("ACTIVE") == Some(0) => Kind::Darken,
            CommitMode::Settle | CommitMode::Modeset => Kind::Light,
        };
        let source =
            wanted("FB_ID").zip(wanted("SRC_Y")).map(|(fb, top)| Source { fb: Id(fb as u32), top: top_of(top) });
        let is_dimmed = wanted("GAMMA_LUT").or(wanted("CTM")).is_some();
        self.pass();
        self.usable(true)?;
        self.inject(kind)?;
        if kind != Kind::Darken {
            let is_alive = source.is_some_and(|source| self.fbs.contains_key(&source.fb));
            assert!(is_alive, "{kind:?} of a framebuffer that is no more");
            self.check(how, request)?;
        }
        match kind {
            Kind::Test => return Ok(()),
            Kind::Flip => {
                let count = 2 + usize::from(is_dimmed);
                assert_eq!(request.0.len(), count, "a flip sets what the plane shows, how bright, and nothing else");
                if is_dimmed && self.family.limits.waits_to_dim {
                    CLOCK.set(self.begins(self.current() + 1).0);
                }
                if let Some(flip) = &self.pending {
                    // The properties may be read after the watchdog's timeout.
                    assert!(self.current() >= flip.vblank + 3, "two commits in flight");
                    return Err(Errno::BUSY.into());
                }
                let (source, effect) = (source.expect("asserted above"), self.lost_flip.take());
                let vblank = self.current() + u64::from(self.family.limits.has_vblanks);
                self.pending = Some(Pending { source, vblank, effect });
            }
            Kind::Light | Kind::Darken => {
                // A blocking commit: what was pending is over, one way or the other, and a vblank has passed.
                self.pending = None;
                CLOCK.set(self.begins(self.current() + 1).0);
                self.modesets += u32::from(how == CommitMode::Modeset && kind == Kind::Light);
                self.on_screen = source.filter(|_| kind == Kind::Light);
            }
        }
        self.apply(request);
        Ok(())
    }

    fn vblank(&mut self, _: u32) -> io::Result<(Vblank, Nanos)> {
        self.usable(false)?;
        if !self.family.limits.has_vblanks {
            return Err(Errno::OPNOTSUPP.into());
        }
        let is_early = self.quirk == Some(Quirk::LateVblanks) && !self.commits.contains_key(&Kind::Flip);
        if is_early || self.value(CRTC, "ACTIVE") == 0 {
            return Err(Errno::INVAL.into());
        }
        Ok((Vblank(self.current() as u32), self.begins(self.current())))
    }

    fn request_vblank(&mut self, _: u32, vblank: Vblank) -> io::Result<()> {
        self.usable(false)?;
        let ahead = vblank.since(Vblank(self.current() as u32));
        self.asked.push(self.current().saturating_add_signed(ahead.into()));
        Ok(())
    }

    fn wait(&mut self, timeout: Duration) -> io::Result<Option<KmsEvent>> {
        self.pass();
        if let Some(happening) = self.happenings.pop_front() {
            self.spins = 0;
            return Ok(Some(happening));
        }
        self.spins = if timeout.is_zero() { self.spins + 1 } else { 0 };
        assert!(self.spins < 100, "a busy wait");
        let end = now().after(timeout.as_nanos() as u64);
        let due = self.next_due().map_or(end, |due| due.min(end));
        CLOCK.set(due.max(now()).0);
        self.pass();
        Ok(self.happenings.pop_front())
    }
}
