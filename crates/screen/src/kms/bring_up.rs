//! From dark to lit.
//!
//! Owns the attempts: open the card, survey it, take the best candidate that the kernel accepts in a test commit,
//! allocate its buffers, and light the first picture. What is on the screen stays until that first picture is ready.

use super::candidate::{Candidate, Framebuffers};
use super::card::{BufferSpec, CommitMode, Id, Kms, Survey};
use super::choose::{Request, candidates};
use super::dimming::Dimming;
use super::light;
use super::plan::Plan;
use super::recovery::destroy;
use super::recovery_policy::{self, CommitError, RecoveryStep};
use super::ring::Ring;
use super::{CommitState, FilledBuffer, KmsScreen, Output, Phase};
use crate::Event;
use crate::vblank_clock::VblankClock;
use rustix::io::Errno;
use std::io;
use std::time::Duration;

/// One on the screen, one pending, one being filled.
const BUFFERS: u32 = 3;
/// Poll interval for displays without a hot-plug event: some drivers detect them only when probed.
const POLL: Duration = Duration::from_secs(2);
/// Poll interval while another console is active: the switch back is an event.
const ELSEWHERE: Duration = Duration::from_hours(1);

/// Why nothing could be lit.
pub(super) enum BringUpError {
    /// No connector has a display with modes.
    NoDisplay,
    /// The kernel refused every way.
    NoWay,
    /// A call failed.
    Failed(io::Error),
}

impl From<io::Error> for BringUpError {
    fn from(error: io::Error) -> Self {
        Self::Failed(error)
    }
}

impl<K: Kms> KmsScreen<K> {
    /// Tries to get from dark to ready; on failure it sets the time of the next attempt.
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
                    tracing::debug!(reason, "cannot light a display yet");
                }
                self.wait_after(&unlit);
            }
        }
    }

    fn wait_after(&mut self, unlit: &BringUpError) {
        let mut pause = recovery_policy::pause(self.tries);
        match unlit {
            BringUpError::NoDisplay => {
                pause = POLL;
                if self.settings.device.is_none() {
                    // The display may be plugged into another card.
                    self.close();
                }
            }
            BringUpError::NoWay => self.refused.clear(),
            BringUpError::Failed(error) if CommitError::of(error) == CommitError::Busy => {}
            BringUpError::Failed(_) => self.close(),
        }
        self.tries = self.tries.saturating_add(1);
        self.phase = Phase::Dark { retry: self.now().after(pause.as_nanos() as u64) };
    }

    fn tell(&self, unlit: &BringUpError) -> String {
        let card = self.kms.name();
        match unlit {
            BringUpError::NoDisplay => format!("no display is connected to {card}"),
            BringUpError::NoWay => format!("{card} rejects every combination of plane, format and mode"),
            BringUpError::Failed(error) if CommitError::of(error) == CommitError::NotMaster => {
                format!("another process is DRM master of {card}")
            }
            BringUpError::Failed(error) => format!("cannot light {card}: {error}"),
        }
    }

    fn prepare(&mut self) -> Result<Output, BringUpError> {
        self.kms.open()?;
        // `EBUSY` means here that another process is DRM master.
        self.kms.take_master().map_err(|error| match CommitError::of(&error) {
            CommitError::Busy => Errno::ACCESS.into(),
            CommitError::Gone | CommitError::NotMaster | CommitError::Refused | CommitError::Broken => error,
        })?;
        let survey = self.kms.survey()?;
        let candidates = self.candidates(&survey);
        if candidates.is_empty() {
            return Err(BringUpError::NoDisplay);
        }
        self.first_accepted(&survey, candidates)?.ok_or(BringUpError::NoWay)
    }

    /// Every candidate for the coming pictures, best first.
    pub(super) fn candidates(&self, survey: &Survey) -> Vec<Candidate> {
        let settings = &self.settings;
        candidates(survey, Request { size: settings.size, fps: settings.fps, output: &settings.output })
    }

    /// The first of `candidates` that the kernel accepts, with its buffers.
    pub(super) fn first_accepted(&mut self, survey: &Survey, candidates: Vec<Candidate>) -> io::Result<Option<Output>> {
        for way in candidates {
            if self.refused.contains(&way) {
                continue;
            }
            match self.build(survey, way) {
                Ok(output) => return Ok(Some(output)),
                Err(error) if CommitError::of(&error) == CommitError::Refused => {
                    tracing::debug!(?way, %error, "the kernel rejects this configuration");
                    self.refused.push(way);
                }
                Err(error) => return Err(error),
            }
        }
        Ok(None)
    }

    /// Allocates the buffers of `way`, and runs a test commit. On failure everything is freed.
    fn build(&mut self, survey: &Survey, way: Candidate) -> io::Result<Output> {
        let size = self.settings.size;
        let mode = self.kms.create_mode(&way.mode)?;
        let mut painted = Vec::new();
        match self.build_buffers(survey, way, mode, &mut painted) {
            Ok(plan) => {
                let (ring, flight) = (Ring::new(painted), CommitState::Landed);
                tracing::info!(connector = plan.connector, ?way, ?size, "chose a display configuration");
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
                    own_vblanks: None,
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
        painted: &mut Vec<FilledBuffer>,
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
            painted.extend(made.iter().map(|&buffer| FilledBuffer { buffer, area: None }));
            // Equal framebuffers are all accepted, but not every row of one.
            for buffer in made.iter().filter(|_| is_first) {
                self.kms.commit(CommitMode::Test, &plan.light(buffer.source))?;
            }
        }
        Ok(plan)
    }

    /// Lights the pending picture, waiting until it is on the screen. `since`: when this was first tried.
    pub(super) fn light(&mut self, since: timing::Nanos) {
        let (now, period) = (self.now(), self.period());
        let Phase::Up(output) = &mut self.phase else { return };
        let Some(source) = output.ring.pending().map(|painted| painted.buffer.source) else { return };
        let first = !output.lit;
        let outcome = light::lit(&mut self.kms, output, source, first).and_then(|()| {
            // From here on the framebuffer is bound, whatever fails later.
            output.lit = true;
            let (plane, survey) = (output.plan.way.plane, &output.survey);
            output.has_colours =
                output.has_colours || output.plan.keeps_colours(&self.kms.plane_properties(plane)?, survey);
            if output.has_colours {
                return Ok(());
            }
            tracing::warn!(
                format = output.plan.way.format.format.name(),
                "the plane did not keep the colour matrix BT.709, trying another format"
            );
            // Other framebuffers would not help: the candidate with our own is refused as well.
            self.refused.push(Candidate { framebuffers: Framebuffers::Own, ..output.plan.way });
            Err(Errno::INVAL.into())
        });
        match outcome {
            Ok(()) => self.is_lit(first),
            Err(error) => {
                let timed_out = now.since(since) >= recovery_policy::patience(period).as_nanos() as u64;
                let step = recovery_policy::light_failed(CommitError::of(&error), timed_out);
                if step == RecoveryStep::Again {
                    output.flight = CommitState::Lighting { next: now.after(period.as_nanos() as u64), since };
                } else {
                    self.recover(step, &format!("a modeset commit failed: {error}"));
                }
            }
        }
    }

    /// Only the pending picture is on the screen.
    fn is_lit(&mut self, first: bool) {
        let Phase::Up(output) = &mut self.phase else { return };
        output.ring.flipped();
        output.flight = CommitState::Landed;
        output.failed_in_a_row += u32::from(!first);
        self.cable.on_lit(self.settings.now);
        let now = (self.settings.now)();
        if first
            && output.own_vblanks.is_none()
            && self.kms.vblank(output.plan.crtc).is_err_and(|error| is_unsupported(&error))
        {
            tracing::info!("the driver has no vblank counter, using a timer");
            output.own_vblanks = Some(VblankClock::new(now, output.plan.refresh));
        }
        let since = output.vblank(&mut self.kms, now);
        if let (Ok((vblank, _)), false, None) = (&since, first, output.own_vblanks) {
            // Events of earlier flips may still arrive.
            output.gave_up_at = Some(*vblank);
        }
        self.free_previous();
        self.drop_stale_flips();
        self.notices.push_back(match since {
            Ok((vblank, at)) if first => Event::Flip { vblank, at },
            // It is committed again, and that flip brings its own vblank.
            Err(error) if first => {
                Event::Recovered { reason: format!("the picture is lit, but its vblank is unknown: {error}") }
            }
            Ok(_) | Err(_) => Event::Recovered {
                reason: "a page flip did not complete; the picture was committed again with a modeset".to_owned(),
            },
        });
    }
}

fn is_unsupported(error: &io::Error) -> bool {
    error.raw_os_error() == Some(Errno::OPNOTSUPP.raw_os_error())
}
