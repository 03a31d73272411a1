//! What a unit tells of itself to an address, if its owner has named one.
//!
//! Owns the document: the unit's name, how the look ended, and the player's status document. It is sent after each look on
//! the schedule, and once: nobody waits for an answer, and that it does not arrive stops nothing. Never sent over TLS by a
//! unit whose clock cannot be right: it could not tell who listens.
//!
//! Start at [`send`].

use crate::answer::Answer;
use crate::fatal::Fatal;
use crate::http_source::{SMALL, agent};
use crate::network_error::of_request;
use crate::options::Order;
use player::day::is_clock_wrong;
use player::ending::chain;
use player::now::clock_s;
use serde::Serialize;
use serde_json::Value;
use std::io;
use std::time::Duration;
use tracing::{info, warn};
use ureq::Agent;

/// How long the player may take to tell its status.
const STATUS: Duration = Duration::from_secs(5);
/// Bytes of that.
const LONGEST: u64 = 1 << 20;

/// The document.
#[derive(Debug, Serialize)]
struct Bulletin<'b> {
    unit: &'b str,
    /// How the look ended.
    update: Option<&'b Answer>,
    /// Why it failed.
    error: Option<String>,
    /// The player's; none if it does not answer.
    status: Option<Value>,
}

/// Tells how the unit is, after a look that ended so.
pub(crate) fn send(order: &Order, ended: Result<&Answer, &Fatal>) {
    let Some(address) = &order.config.report_to else { return };
    let is_clock_wrong = is_clock_wrong(clock_s());
    if is_clock_wrong && address.starts_with("https://") {
        return info!("nobody is told how this unit is before it knows the time");
    }
    let sent =
        agent(address, order.config.proxy.as_deref(), is_clock_wrong).map_err(io::Error::other).and_then(|agent| {
            let bulletin = Bulletin {
                unit: order.unit.as_str(),
                update: ended.ok(),
                error: ended.err().map(|fatal| chain(fatal)),
                status: status(&order.config.status),
            };
            post(&agent, address, &bulletin)
        });
    if let Err(error) = sent {
        warn!(address, error = chain(&error), "nobody is told how this unit is");
    }
}

fn post(agent: &Agent, address: &str, bulletin: &Bulletin<'_>) -> io::Result<()> {
    let text = serde_json::to_vec(bulletin).map_err(io::Error::other)?;
    let request = agent.post(address).config().timeout_global(Some(SMALL)).build().content_type("application/json");
    let status = request.send(&text[..]).map_err(of_request)?.status();
    if status.is_success() { Ok(()) } else { Err(io::Error::other(format!("the server answers {status}"))) }
}

/// The status document of the player at `place` on this machine.
fn status(place: &str) -> Option<Value> {
    let url = format!("http://{place}");
    let agent = agent(&url, None, false).ok()?;
    let request = agent.get(format!("{url}/status.json")).config().timeout_global(Some(STATUS)).build();
    let mut response = request.call().ok()?;
    let text = response.body_mut().with_config().limit(LONGEST).read_to_vec().ok()?;
    serde_json::from_slice(&text).ok()
}
