//! The clips that come next.
//!
//! Owns the plan that the clip source makes and others look at. Never chooses a clip.

use crate::stream::scheduled_clip::Turn;
use player::lock::hold;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

/// The clips that are scheduled and not over, in their order.
#[derive(Debug, Default)]
pub(crate) struct Plan(Mutex<VecDeque<Arc<Turn>>>);

impl Plan {
    /// Adds a clip, and forgets those up to the clip `on_screen`.
    pub(crate) fn add(&self, turn: Arc<Turn>, on_screen: Option<u64>) {
        let mut plan = hold(&self.0);
        plan.retain(|turn| Some(turn.number) > on_screen);
        plan.push_back(turn);
    }

    /// Removes a clip that ended without a picture.
    pub(crate) fn remove(&self, number: u64) {
        hold(&self.0).retain(|turn| turn.number != number);
    }

    /// The clip that follows clip `number`, if it is planned.
    pub(crate) fn after(&self, number: u64) -> Option<Arc<Turn>> {
        hold(&self.0).iter().find(|turn| turn.number > number).map(Arc::clone)
    }
}

#[cfg(test)]
mod tests {
    use super::Plan;
    use crate::stream::scheduled_clip::tests::turns;

    #[test]
    fn a_clip_that_ended_without_a_picture_is_not_planned_any_more() {
        let plan = Plan::default();
        for turn in turns(3, 2) {
            plan.add(turn, None);
        }
        plan.remove(2);
        assert_eq!(plan.after(1).map(|turn| turn.number), Some(3));
        plan.remove(3);
        assert!(plan.after(1).is_none());
    }
}
