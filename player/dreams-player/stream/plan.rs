//! The clips that come next.
//!
//! Owns the plan that the clip source makes and others look at. Never chooses a clip.

use crate::stream::scheduled_clip::ScheduledClip;
use player::hold;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

/// The clips that are scheduled and not over, in their order.
#[derive(Debug, Default)]
pub(crate) struct Plan(Mutex<VecDeque<Arc<ScheduledClip>>>);

impl Plan {
    /// Adds a clip, and forgets those up to the clip `on_screen`.
    pub(crate) fn add(&self, scheduled: Arc<ScheduledClip>, on_screen: Option<u64>) {
        let mut plan = hold(&self.0);
        plan.retain(|scheduled| Some(scheduled.number) > on_screen);
        plan.push_back(scheduled);
    }

    /// Removes a clip that ended without a picture.
    pub(crate) fn remove(&self, number: u64) {
        hold(&self.0).retain(|scheduled| scheduled.number != number);
    }

    /// The clip that follows clip `number`, if it is planned.
    pub(crate) fn after(&self, number: u64) -> Option<Arc<ScheduledClip>> {
        hold(&self.0).iter().find(|scheduled| scheduled.number > number).map(Arc::clone)
    }
}

#[cfg(test)]
mod tests {
    use super::Plan;
    use crate::stream::scheduled_clip::tests::scheduled_clips;

    #[test]
    fn a_clip_that_ended_without_a_picture_is_not_planned_any_more() {
        let plan = Plan::default();
        for scheduled in scheduled_clips(3, 2) {
            plan.add(scheduled, None);
        }
        plan.remove(2);
        assert_eq!(plan.after(1).map(|scheduled| scheduled.number), Some(3));
        plan.remove(3);
        assert!(plan.after(1).is_none());
    }
}
