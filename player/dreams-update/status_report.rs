//! The status report that a unit sends to an address, if its config has one (`report_to`).
//!
//! Owns the document: the unit's name, the result of the update run, the state of the machine, the player's status
//! document, and if its config says so the votes of the people before it. It is sent once after each run on the schedule,
//! or as often as the owner says (`report_every`); if it does not arrive nothing else changes. Never sent over TLS by a
//! unit that does not know the time: it could not fully check the certificate.
//!
//! Start at [`send`].

use crate::answer::Answer;
use crate::http_source::{SMALL, agent};
use crate::machine::Machine;
use crate::network_error::of_request;
use crate::options::Order;
use ct_codecs::{Base64, Encoder};
use diagnostics::chain;
use serde::Serialize;
use serde_json::Value;
use std::io;
use std::path::Path;
use std::time::Duration;
use tracing::{info, warn};
use ureq::Agent;
use votes::{Store, Totals};

/// How long the player may take to answer.
const STATUS: Duration = Duration::from_secs(5);
/// Bytes of that.
const LONGEST: u64 = 1 << 20;

/// The document.
#[derive(Debug, Serialize)]
struct StatusReport<'b> {
    unit: &'b str,
    /// The result of the run.
    update: Option<&'b Answer>,
    /// Why it failed.
    error: Option<String>,
    machine: Machine,
    /// The player's; none if it does not answer.
    status: Option<Value>,
    /// What is shown, as a small JPEG in Base64; none where the owner has no `report_picture`, or the player does not answer.
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<String>,
    /// The totals of the votes; none where the config has no `votes`, or none were counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    votes: Option<Totals>,
}

/// Sends the report: of an update run that gave this answer, or why the last one failed, if it did.
pub(crate) fn send(order: &Order, ended: Result<&Answer, Option<String>>) {
    let Some(address) = &order.config.report_to else { return };
    let is_time_known = order.clock.read().known_s().is_some();
    if !is_time_known && address.starts_with("https://") {
        return info!("no status report is sent over HTTPS before the time is known");
    }
    let sent =
        agent(address, order.config.proxy.as_deref(), order.judgement()).map_err(io::Error::other).and_then(|agent| {
            let report = StatusReport {
                unit: order.unit.as_str(),
                update: ended.as_ref().ok().copied(),
                error: ended.err().flatten(),
                machine: Machine::of(order, address),
                status: from_player(order, "status.json").and_then(|text| serde_json::from_slice(&text).ok()),
                picture: order.report_picture.then(|| picture(order)).flatten(),
                votes: order.config.votes.as_deref().and_then(votes),
            };
            post(&agent, address, &report)
        });
    if let Err(error) = sent {
        warn!(address, error = chain(&error), "cannot send the status report");
    }
}

fn post(agent: &Agent, address: &str, report: &StatusReport<'_>) -> io::Result<()> {
    let text = serde_json::to_vec(report).map_err(io::Error::other)?;
    let request = agent.post(address).config().timeout_global(Some(SMALL)).build().content_type("application/json");
    let status = request.send(&text[..]).map_err(of_request)?.status();
    if status.is_success() { Ok(()) } else { Err(io::Error::other(format!("the server answers {status}"))) }
}

/// What `dreams-votes --show` prints of the votes in `store`.
fn votes(store: &Path) -> Option<Totals> {
    let kept = Store::open(store).inspect_err(|error| warn!(error = chain(error), "no votes are reported"));
    kept.ok()?.1.map(|ledger| ledger.sent())
}

fn picture(order: &Order) -> Option<String> {
    let jpeg = from_player(order, "small.jpg")?;
    Base64::encode_to_string(jpeg).inspect_err(|error| warn!(error = chain(error), "no picture is reported")).ok()
}

/// A document of the player on this machine.
fn from_player(order: &Order, name: &str) -> Option<Vec<u8>> {
    let url = format!("http://{}", order.config.status);
    let agent = agent(&url, None, order.judgement()).ok()?;
    let request = agent.get(format!("{url}/{name}")).config().timeout_global(Some(STATUS)).build();
    request.call().ok()?.body_mut().with_config().limit(LONGEST).read_to_vec().ok()
}
