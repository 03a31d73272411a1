//! The walk of an agent's string.
//!
//! Owns the expansion, which is never written down: a stack of as many places as there are rounds is all that it needs, and
//! it ends at its limits whatever the rules say. Never scales or draws.
//!
//! Start at [`walk`].

use crate::pfeiffer::{Act, Pfeiffer};

/// Most characters that are looked at.
const MOST_STEPS: usize = 400_000;
/// Most brackets within each other.
const DEEPEST: usize = 200;
/// Most bytes that a walk holds: both of its stacks, while they grow.
pub(crate) const WALK_BYTES: u64 = 32 * 1024;

/// A step that is drawn, in steps from the start: right and down.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stroke {
    pub(crate) from: [f64; 2],
    pub(crate) to: [f64; 2],
    /// In how many brackets it is.
    pub(crate) depth: usize,
}

/// Goes along the string with turns of `degrees`, upwards first. Returns whether it came to the string's end.
pub(crate) fn walk(agent: &Pfeiffer, degrees: f64, mut visit: impl FnMut(Stroke)) -> bool {
    let (mut at, mut turns) = ([0.0, 0.0], 0_i32);
    let (mut places, mut brackets) = (vec![(0, 0)], Vec::new());
    let (mut steps, mut drawn) = (0, 0);
    while let Some((list, next)) = places.last_mut() {
        steps += 1;
        let Some(letter) = agent.lists[*list].get(*next) else {
            places.pop();
            continue;
        };
        if steps > MOST_STEPS {
            return false;
        }
        *next += 1;
        if let Some(becomes) = letter.becomes
            && places.len() <= agent.it as usize
        {
            places.push((becomes, 0));
            continue;
        }
        match letter.act {
            Act::Draw if drawn == agent.most => return false,
            Act::Draw => {
                let (sine, cosine) = libm::sincos((f64::from(turns) * degrees % 360.0).to_radians());
                let to = [at[0] + sine, at[1] - cosine];
                visit(Stroke { from: at, to, depth: brackets.len() });
                (at, drawn) = (to, drawn + 1);
            }
            Act::Clockwise => turns += 1,
            Act::Back => turns -= 1,
            Act::Open if brackets.len() == DEEPEST => return false,
            Act::Open => brackets.push((at, turns)),
            Act::Close => (at, turns) = brackets.pop().unwrap_or((at, turns)),
            Act::Nothing => {}
        }
    }
    true
}

impl Pfeiffer {
    /// How many segments are drawn.
    pub fn segments(&self) -> usize {
        let mut segments = 0;
        walk(self, self.v, |_| segments += 1);
        segments
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(text: &str) -> Vec<[i32; 2]> {
        let (mut ends, agent) = (Vec::new(), Pfeiffer::read(text));
        walk(&agent, agent.v, |stroke| ends.push(stroke.to.map(|part| (part * 100.0).round() as i32)));
        ends
    }

    #[test]
    fn plus_turns_clockwise_and_brackets_return() {
        assert_eq!(ends("v=90&it=0&str=F+F-F"), [[0, -100], [100, -100], [100, -200]]);
        assert_eq!(ends("v=90&it=0&str=]F[+F]F"), [[0, -100], [100, -100], [0, -200]]);
        assert_eq!(ends("v=90&it=2&str=X&rules=('X','F+X')"), [[0, -100], [100, -100]]);
    }

    #[test]
    fn a_walk_ends_at_its_limits_whatever_the_rules_say() {
        for (text, segments) in [
            ("it=60&str=F", 2000),
            ("it=60&str=F&rules=('F','FF')", 20_000),
            ("it=60&str=X&rules=('X','XX')", 0),
            ("it=60&str=X&rules=('X','[X')", 0),
            ("it=60&str=FX&rules=('X','F[[[[[[[[[[[[[[[[[[[[[[[[[X')", 10),
        ] {
            assert_eq!(Pfeiffer::read(text).segments(), segments, "{text}");
        }
    }
}
