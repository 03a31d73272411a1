//! Loops: an expression whose time goes round.
//!
//! Owns what is moving, and the loop. The frame number is taken modulo the loop's length before anything else is done
//! with it, so frame F is frame 0. Never draws.
//!
//! Start at [`Loop`]; `dissolve.rs` has the transitions.

use crate::genome::{Genome, Map, View};
use crate::node::Node;
use crate::still::{Clock, Still};

/// Something that is an expression at every frame.
pub trait Moving: Send + Sync {
    /// Which part of the plane is seen at `frame`, while the shutter is open `shutter` frames from the middle.
    fn view(&self, frame: f64, shutter: f64) -> View;
    /// The expression at `frame`, while the shutter is open `shutter` frames from the middle.
    fn still(&self, frame: f64, shutter: f64) -> Still;
}

/// A genome that turns.
#[derive(Clone, Debug)]
pub struct Loop {
    picture: Node,
    map: Map,
    turns: f64,
    frames: f64,
}

impl Loop {
    /// The loop of a genome, in `frames` frames (> 0).
    pub fn new(genome: &Genome, frames: f64) -> Loop {
        Loop { picture: genome.picture.clone(), map: genome.map, turns: f64::from(genome.turns), frames }
    }

    pub(crate) fn picture(&self) -> &Node {
        &self.picture
    }

    /// Turns a frame.
    pub(crate) fn speed(&self) -> f64 {
        self.turns / self.frames
    }

    pub(crate) fn clock(&self, frame: f64) -> Clock {
        Clock { turns: self.turns * (frame.rem_euclid(self.frames) / self.frames), turns_per_frame: self.speed() }
    }
}

impl Moving for Loop {
    fn view(&self, frame: f64, shutter: f64) -> View {
        self.map.at(self.clock(frame).at(shutter))
    }

    fn still(&self, frame: f64, shutter: f64) -> Still {
        Still::of(&self.picture, self.clock(frame).at(shutter))
    }
}
