//! From dark to lit.
//!
//! Owns the attempts: open the card, survey it, take the best way that the kernel accepts in a test commit, make its
//! buffers, and light the first picture. Never removes what is on the glass before that first picture is ready.

use super::candidate::{Candidate, Framebuffers};
use super::card::{BufferSpec, How, Id, Kms, Survey};
use super::choose::{Request, candidates};
use super::dimming::Dimming;
use super::ladder::{self, Rung, Trouble};
use super::light;
use super::plan::Plan;
use super::recovery::destroy;
use super::ring::Ring;
use super::{Flight, KmsScreen, Output, Painted, Phase};
use crate::Event;
use crate::beat::Beat;
use rustix::io::Errno;
use std::io;
use std::time::Duration;

/// One on the glass, one pending, one being filled.
const BUFFERS: u32 = 3;
/// How often we look for a display although no event told of one: some drivers only find out when asked.
const LOOK: Duration = Duration::from_secs(2);
/// How often we look up while somebody looks at another console: its switch back is told.
const ELSEWHERE: Duration = Duration::from_hours(1);

/// Why nothing could be lit.
pub(super) enum Unlit {
    /// No connector has a display with modes.
    NoDisplay,
    /// The kernel refused every way.
    NoWay,
    /// A call failed.
    Failed(io::Error),
}

impl From<io::Error> for Unlit {
    fn from(error: io::Error) -> Self {
        Self::Failed(error)
    }
}

impl<K: Kms> KmsScreen<K> {
    /// Tries to get from dark to ready; sets the time of the next attempt if that fails.
    pub(super) fn attempt(&mut self) {
        if self.is_elsewhere {
            self.phase = Phase::Dark { retry: self.now().after(ELSEWHERE.as_nanos() as u64) };
            return;
        }
        match self.prepare() {
            Ok(output) => {
                self.phase = Phase::Up(Box::new(output));
                self.notices.push_back(Event::Back);
            }
            Err(unlit) => {
                let reason = self.tell(&unlit);
                if self.tries == 0 {
                    self.notices.push_back(Event::Lost { reason });
                } else {
                    tracing::debug!(reason, "still dark");
                }
                self.wait_after(&unlit);
            }
        }
    }

    fn wait_after(&mut self, unlit: &Unlit) {
        let mut pause = ladder::pause(self.tries);
        match unlit {
            Unlit::NoDisplay => {
                pause = LOOK;
                if self.settings.device.is_none() {
                    // The display may come at another card.
                    self.close();
                }
            }
            Unlit::NoWay => self.refused.clear(),
            Unlit::Failed(error) if Trouble::of(error) == Trouble::Busy => {}
            Unlit::Failed(_) => self.close(),
        }
        self.tries = self.tries.saturating_add(1);
        self.phase = Phase::Dark { retry: self.now().after(pause.as_nanos() as u64) };
    }

    fn tell(&self, unlit: &Unlit) -> String {
        let card = self.kms.name();
        match unlit {
            Unlit::NoDisplay => format!("no display is plugged into {card}"),
            Unlit::NoWay => format!("{card} refuses every plane, format and mode"),
            Unlit::Failed(error) if Trouble::of(error) == Trouble::NotMaster => {
                format!("another process is master of {card}")
            }
            Unlit::Failed(error) => format!("cannot light {card}: {error}"),
        }
    }

    fn prepare(&mut self) -> Result<Output, Unlit> {
        self.kms.open()?;
        // Busy means here that there is another master.
        self.kms.take_master().map_err(|error| match Trouble::of(&error) {
            Trouble::Busy => Errno::ACCESS.into(),
            Trouble::Gone | Trouble::NotMaster | Trouble::Refused | Trouble::Broken => error,
        })?;
        let survey = self.kms.survey()?;
        let ways = self.ways(&survey);
        if ways.is_empty() {
            return Err(Unlit::NoDisplay);
        }
        self.accepted(&survey, ways)?.ok_or(Unlit::NoWay)
    }

    /// Every way to light the pictures to come, best first.
    pub(super) fn ways(&self, survey: &Survey) -> Vec<Candidate> {
        let settings = &self.settings;
        candidates(survey, Request { size: settings.size, fps: settings.fps, output: &settings.output })
    }

    /// The first of `ways` that the kernel accepts, with its buffers.
    pub(super) fn accepted(&mut self, survey: &Survey, ways: Vec<Candidate>) -> io::Result<Option<Output>> {
        for way in ways {
            if self.refused.contains(&way) {
                continue;
            }
            match self.build(survey, way) {
                Ok(output) => return Ok(Some(output)),
                Err(error) if Trouble::of(&error) == Trouble::Refused => {
                    tracing::debug!(?way, %error, "the kernel refuses this way");
                    self.refused.push(way);
                }
                Err(error) => return Err(error),
            }
        }
        Ok(None)
    }

    /// Makes the buffers of `way`, and asks the kernel whether it would light them. Leaves nothing behind on failure.
    fn build(&mut self, survey: &Survey, way: Candidate) -> io::Result<Output> {
        let size = self.settings.size;
        let mode = self.kms.create_mode(&way.mode)?;
        let mut painted = Vec::new();
        match self.build_buffers(survey, way, mode, &mut painted) {
            Ok(plan) => {
                let (ring, flight) = (Ring::new(painted), Flight::Landed);
                tracing::info!(connector = plan.connector, ?way, ?size, "chose a way to light the picture");
                let dimming = Dimming::new(&mut self.kms, &plan, self.light);
                Ok(Output {
                    plan,
                    made_for: self.settings.output.clone(),
                    survey: survey.clone(),
                    mode,
                    ring,
                    lit: false,
                    flight,
                    asked: None,
                    beat: None,
                    gave_up_at: None,
                    failed_in_a_row: 0,
                    dimming,
                    has_colours: false,
                })
            }
            Err(error) => {
                destroy(&mut self.kms, painted);
                self.kms.destroy_blob(mode);
                Err(error)
            }
        }
    }

    fn build_buffers(
        &mut self,
        survey: &Survey,
        way: Candidate,
        mode: Id,
        painted: &mut Vec<Painted>,
    ) -> io::Result<Plan> {
        let (size, output) = (self.settings.size, &self.settings.output);
        let plan = Plan::new(survey, way, size, mode, output).ok_or(Errno::INVAL)?;
        let count = match way.framebuffers {
            Framebuffers::Shared => BUFFERS,
            Framebuffers::Own => 1,
        };
        let spec = BufferSpec { size: way.buffer_size(size), format: way.format, count };
        while painted.len() < BUFFERS as usize {
            let is_first = painted.is_empty();
            let made = self.kms.create(spec)?;
            painted.extend(made.iter().map(|&buffer| Painted { buffer, area: None }));
            // Framebuffers that are alike are taken alike, but not every place in one.
            for buffer in made.iter().filter(|_| is_first) {
                self.kms.commit(How::Test, &plan.light(buffer.source))?;
            }
        }
        Ok(plan)
    }

    /// Lights the pending picture, waiting until it is on the glass. `since`: when this was first tried.
    pub(super) fn light(&mut self, since: timing::Nanos) {
        let (now, period) = (self.now(), self.period());
        let Phase::Up(output) = &mut self.phase else { return };
        let Some(source) = output.ring.pending().map(|painted| painted.buffer.source) else { return };
        let first = !output.lit;
        let outcome = light::lit(&mut self.kms, output, source, first).and_then(|()| {
            // From here on the framebuffer is bound, whatever else may be wrong.
            output.lit = true;
            let (plane, survey) = (output.plan.way.plane, &output.survey);
            output.has_colours =
                output.has_colours || output.plan.colours_stand(&self.kms.plane_properties(plane)?, survey);
            if output.has_colours {
                return Ok(());
            }
            tracing::warn!(format = output.plan.way.format.format.name(), "the plane did not keep our colour matrix");
            // In other framebuffers it would not either.
            self.refused.push(Candidate { framebuffers: Framebuffers::Own, ..output.plan.way });
            Err(Errno::INVAL.into())
        });
        match outcome {
            Ok(()) => self.is_lit(first),
            Err(error) => {
                let barked = now.since(since) >= ladder::patience(period).as_nanos() as u64;
                let rung = ladder::light_failed(Trouble::of(&error), barked);
                if rung == Rung::Again {
                    output.flight = Flight::Lighting { next: now.after(period.as_nanos() as u64), since };
                } else {
                    self.climb(rung, &format!("lighting failed: {error}"));
                }
            }
        }
    }

    /// The pending picture is on the glass, alone.
    fn is_lit(&mut self, first: bool) {
        let Phase::Up(output) = &mut self.phase else { return };
        output.ring.flipped();
        output.flight = Flight::Landed;
        output.failed_in_a_row += u32::from(!first);
        self.cable.lights(self.settings.now);
        let now = (self.settings.now)();
        if first
            && output.beat.is_none()
            && self.kms.vblank(output.plan.crtc).is_err_and(|error| is_unsupported(&error))
        {
            tracing::info!("the driver has no vblanks, counting our own");
            output.beat = Some(Beat::new(now, output.plan.refresh));
        }
        let since = output.vblank(&mut self.kms, now);
        if let (Ok((vblank, _)), false, None) = (&since, first, output.beat) {
            // The events of flips before this may yet come.
            output.gave_up_at = Some(*vblank);
        }
        self.retire();
        self.drop_stale_flips();
        self.notices.push_back(match since {
            Ok((vblank, at)) if first => Event::Flip { vblank, at },
            // It is committed again, and that flip brings its own vblank.
            Err(error) if first => Event::Recovered { reason: format!("lit, but nobody knows since when: {error}") },
            Ok(_) | Err(_) => {
                Event::Recovered { reason: "a flip did not come; the picture was lit anew, waiting".to_owned() }
            }
        });
    }
}

fn is_unsupported(error: &io::Error) -> bool {
    error.raw_os_error() == Some(Errno::OPNOTSUPP.raw_os_error())
}
