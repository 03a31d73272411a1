//! Sends alarms to the webhook.
//!
//! Owns the requests, the tries after a failure, and the file `alarms` in the folder, which knows what was sent last: a
//! restart sends nothing twice. What is due is known to [`super::alarm`]. The address may hold a secret: it is never
//! printed.
//!
//! Start at [`Webhook::send`].

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use operations::program::{Exit, Fatal, now, print};
use ureq::Agent;

use crate::alarm::{Alarm, Sent, wait_s};
use crate::desk::Desk;
use crate::record::UnitView;

/// The file in the folder. It has no ending: `dreams votes` reads all that end in `.json`.
const FILE: &str = "alarms";
/// The most bytes of it: a line for each unit.
const MOST_BYTES: u64 = 4 << 20;
/// How long the webhook may take.
const LONGEST: Duration = Duration::from_secs(20);
/// How often it is looked whether alarms are due.
const LOOK: Duration = Duration::from_secs(1);

/// The webhook, and what was sent to it.
pub(crate) struct Webhook {
    agent: Agent,
    url: String,
    file: PathBuf,
    sent: Sent,
}

/// What became of the alarms that were due.
#[derive(Debug, Default)]
pub(crate) struct Sending {
    /// How many were sent.
    pub(crate) sent: u64,
    /// Why the others were not.
    pub(crate) failed: Vec<WebhookError>,
}

#[derive(Debug, thiserror::Error)]
pub(crate) enum WebhookError {
    #[error("cannot send the alarm of `{unit}`: {why}")]
    Send { unit: String, why: String },
    #[error("`{path}` is not a list of alarms that were sent: {source}")]
    Malformed { path: PathBuf, source: serde_json::Error },
    #[error("cannot save which alarms were sent")]
    Save(#[source] io::Error),
}

impl Webhook {
    /// The webhook at `url`, with what was sent to it from `folder`.
    /// Errors: If the list of that cannot be read.
    pub(crate) fn open(url: &str, folder: &Path) -> Result<Self, Fatal> {
        let file = folder.join(FILE);
        let sent = match durable::read_plain(&file, MOST_BYTES) {
            Ok(text) => serde_json::from_slice(&text).map_err(|source| {
                let malformed = WebhookError::Malformed { path: file.clone(), source };
                Fatal::new(Exit::Malformed, malformed).hint("remove it: then what is wrong now is sent once more")
            })?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => Sent::default(),
            Err(source) => return Err(Fatal::read(&file, source)),
        };
        let config = Agent::config_builder()
            .timeout_global(Some(LONGEST))
            .max_redirects(0)
            .http_status_as_error(false)
            .user_agent(concat!("dreams-fleet/", env!("CARGO_PKG_VERSION")));
        Ok(Self { agent: config.build().into(), url: url.to_owned(), file, sent })
    }

    /// Sends what is due for `views`; begins with no further alarm once `stop` is raised.
    pub(crate) fn send(&mut self, views: &[UnitView], stop: &AtomicBool) -> Sending {
        let (before, mut sending) = (self.sent.clone(), Sending::default());
        for alarm in self.sent.due(views) {
            if stop.load(Ordering::Relaxed) {
                break;
            }
            match self.post(&alarm) {
                Ok(()) => {
                    self.sent.note(&alarm);
                    sending.sent += 1;
                    sending.failed.extend(self.save().err());
                }
                Err((why, is_reached)) => {
                    sending.failed.push(WebhookError::Send { unit: alarm.unit, why });
                    if !is_reached {
                        break;
                    }
                }
            }
        }
        if sending.sent == 0 && self.sent != before {
            sending.failed.extend(self.save().err());
        }
        sending
    }

    /// Errors: Why it was not sent, and whether the webhook answered at all.
    fn post(&self, alarm: &Alarm) -> Result<(), (String, bool)> {
        let text = serde_json::to_vec(alarm).expect("names and numbers are JSON");
        let answer = self.agent.post(&self.url).content_type("application/json").send(&text[..]);
        let status = answer.map_err(|error| (error.to_string(), false))?.status();
        if status.is_success() { Ok(()) } else { Err((format!("the webhook answers {status}"), true)) }
    }

    fn save(&self) -> Result<(), WebhookError> {
        let text = serde_json::to_vec_pretty(&self.sent).expect("names and numbers are JSON");
        durable::write_with_mode(&self.file, &text, 0o600).map_err(WebhookError::Save)
    }
}

/// Sends what is due until `stop` is raised.
/// Errors: If the system gives no thread.
pub(crate) fn watch(mut webhook: Webhook, desk: Arc<Desk>, stop: Arc<AtomicBool>) -> io::Result<JoinHandle<()>> {
    let look = move || {
        let mut failures = 0_u32;
        while !stop.load(Ordering::Relaxed) {
            let Sending { sent, failed } = webhook.send(&desk.views(now::since_1970_ms() / 1000), &stop);
            desk.counts.alarms_sent.fetch_add(sent, Ordering::Relaxed);
            desk.counts.alarms_failed.fetch_add(failed.len() as u64, Ordering::Relaxed);
            let wait = if let Some(first) = failed.first() {
                failures = failures.saturating_add(1);
                let wait = wait_s(failures);
                print::note(&format!("note: {first}; the next try is in {wait} seconds"));
                Duration::from_secs(wait)
            } else {
                failures = 0;
                LOOK
            };
            now::pause(wait, &stop);
        }
    };
    Builder::new().name("alarms".to_owned()).spawn(look)
}

/// `https://example.org/hook`: the address of a webhook.
pub(crate) fn address(text: &str) -> Result<String, String> {
    let is_fine = ["https://", "http://"].iter().any(|scheme| text.starts_with(scheme)) && text.len() <= 2048;
    let uri: Option<ureq::http::Uri> = text.parse().ok().filter(|_| is_fine);
    uri.map(|_| text.to_owned()).ok_or_else(|| "wanted an address such as https://example.org/hook".to_owned())
}

#[cfg(test)]
mod tests {
    use super::address;

    #[test]
    fn a_webhook_has_a_whole_address() {
        for fine in ["https://example.org/hook?key=a", "http://127.0.0.1:9/"] {
            assert_eq!(address(fine).as_deref(), Ok(fine));
        }
        for bad in ["", "example.org", "ftp://example.org", "https://", "http:///hook", "https://a b", "https://\n"] {
            assert!(address(bad).is_err(), "{bad}");
        }
    }
}
