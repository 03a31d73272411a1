//! TLS with a web server: whose certificates are accepted, and the connection.
//!
//! Owns both. The authorities are those that are built in, the system's, and the owner's. Chain, name and signature of a
//! certificate are always verified. Its dates are judged by the clock; but where no time server has set the clock, a
//! certificate that is not valid yet says that the clock is behind, and its dates are judged as of the day on which it
//! becomes valid. Nothing more hangs on that: TLS is for privacy, the signatures of bundles are the trust.
//!
//! Start at [`Tls`].

use player::Clock;
use rustls::client::WebPkiServerVerifier;
use rustls::client::danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier};
use rustls::crypto::{CryptoProvider, ring};
use rustls::pki_types::{CertificateDer, ServerName, UnixTime};
use rustls::{
    CertificateError, ClientConfig, ClientConnection, DigitallySignedStruct, RootCertStore, SignatureScheme,
    StreamOwned,
};
use settings::authorities::Authorities;
use std::fmt;
use std::fs;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use std::time::Duration;
use tracing::warn;
use ureq::Error;
use ureq::unversioned::transport::{
    Buffers, ConnectionDetails, Connector, Either, LazyBuffers, NextTimeout, Transport, TransportAdapter,
};

/// Certificates of a chain that may be not valid yet, each later than the one before.
const CHAIN: usize = 8;

/// By what the certificates of servers are judged.
#[derive(Clone, Debug)]
pub(crate) struct Judgement {
    /// The file of the system's authorities, in PEM.
    pub(crate) system: PathBuf,
    /// Those of the owner.
    pub(crate) owners: Authorities,
    /// The clock, and what is known of it.
    pub(crate) clock: Clock,
}

/// Makes TLS connections. What they need is read before the first one.
#[derive(Debug)]
pub(crate) struct Tls {
    judgement: Judgement,
    config: OnceLock<Arc<ClientConfig>>,
}

impl Tls {
    pub(crate) fn new(judgement: Judgement) -> Self {
        Self { judgement, config: OnceLock::new() }
    }
}

impl<In: Transport> Connector<In> for Tls {
    type Out = Either<In, TlsTransport>;

    fn connect(&self, details: &ConnectionDetails<'_>, chained: Option<In>) -> Result<Option<Self::Out>, Error> {
        let Some(transport) = chained else { return Ok(None) };
        if !details.needs_tls() || transport.is_tls() {
            return Ok(Some(Either::A(transport)));
        }
        let host = details.uri.host().unwrap_or_default().trim_matches(['[', ']']).to_owned();
        let name = ServerName::try_from(host.clone()).map_err(|_| Error::BadUri(host))?;
        let config = self.config.get_or_init(|| Arc::new(client_config(&self.judgement)));
        let mut connection = ClientConnection::new(Arc::clone(config), name)?;
        let boxed: Box<dyn Transport> = Box::new(transport);
        let mut below = TransportAdapter::new(boxed, Arc::clone(&details.current_time));
        below.set_timeout(details.timeout);
        connection.complete_io(&mut below)?;
        let buffers = LazyBuffers::new(details.config.input_buffer_size(), details.config.output_buffer_size());
        Ok(Some(Either::B(TlsTransport { buffers, stream: StreamOwned::new(connection, below) })))
    }
}

/// A connection.
pub(crate) struct TlsTransport {
    buffers: LazyBuffers,
    stream: StreamOwned<ClientConnection, TransportAdapter>,
}

impl fmt::Debug for TlsTransport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TlsTransport").finish_non_exhaustive()
    }
}

impl Transport for TlsTransport {
    fn buffers(&mut self) -> &mut dyn Buffers {
        &mut self.buffers
    }

    fn transmit_output(&mut self, amount: usize, timeout: NextTimeout) -> Result<(), Error> {
        self.stream.sock.set_timeout(timeout);
        Ok(self.stream.write_all(&self.buffers.output()[..amount])?)
    }

    fn await_input(&mut self, timeout: NextTimeout) -> Result<bool, Error> {
        self.stream.sock.set_timeout(timeout);
        let count = self.stream.read(self.buffers.input_append_buf())?;
        self.buffers.input_appended(count);
        Ok(count > 0)
    }

    fn is_open(&mut self) -> bool {
        self.stream.sock.get_mut().is_open()
    }

    fn is_tls(&self) -> bool {
        true
    }
}

/// Judges certificates.
#[derive(Debug)]
struct Judge {
    chain: Arc<WebPkiServerVerifier>,
    clock: Clock,
}

impl ServerCertVerifier for Judge {
    fn verify_server_cert(
        &self,
        end_entity: &CertificateDer<'_>,
        intermediates: &[CertificateDer<'_>],
        name: &ServerName<'_>,
        ocsp: &[u8],
        _now: UnixTime,
    ) -> Result<ServerCertVerified, rustls::Error> {
        judged(&self.clock, |at| self.chain.verify_server_cert(end_entity, intermediates, name, ocsp, at))
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        self.chain.verify_tls12_signature(message, certificate, signed)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        self.chain.verify_tls13_signature(message, certificate, signed)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.chain.supported_verify_schemes()
    }
}

/// What `judge` says at the earliest time that it can be by `clock`; where no time server has set that, at the first time
/// from then on at which no certificate is of the future.
fn judged<T>(clock: &Clock, judge: impl Fn(UnixTime) -> Result<T, rustls::Error>) -> Result<T, rustls::Error> {
    let mut at = UnixTime::since_unix_epoch(Duration::from_secs(clock.least_s()));
    for _ in 0..CHAIN {
        match judge(at) {
            Err(rustls::Error::InvalidCertificate(CertificateError::NotValidYetContext { not_before, .. }))
                if !clock.is_synchronised =>
            {
                at = not_before;
            }
            judged => return judged,
        }
    }
    judge(at)
}

fn client_config(judgement: &Judgement) -> ClientConfig {
    let provider: Arc<CryptoProvider> = Arc::new(ring::default_provider());
    let chain = WebPkiServerVerifier::builder_with_provider(Arc::new(authorities(judgement)), Arc::clone(&provider));
    let chain = chain.build().expect("there are authorities, and no lists of revoked certificates");
    let judge = Arc::new(Judge { chain, clock: judgement.clock });
    let config = ClientConfig::builder_with_provider(provider).with_safe_default_protocol_versions();
    let config = config.expect("ring has what they need").dangerous().with_custom_certificate_verifier(judge);
    config.with_no_client_auth()
}

/// All who may vouch for a server.
fn authorities(judgement: &Judgement) -> RootCertStore {
    let mut store = RootCertStore { roots: webpki_roots::TLS_SERVER_ROOTS.to_vec() };
    store.add_parsable_certificates(judgement.owners.certificates().iter().cloned());
    let path = judgement.system.display();
    match fs::read(&judgement.system) {
        Ok(bytes) => {
            let (systems, unreadable) = Authorities::readable(&bytes);
            let readable = systems.certificates().len();
            if unreadable > 0 || readable == 0 {
                warn!(%path, readable, unreadable, "not all of the system's certificate authorities can be read");
            }
            store.add_parsable_certificates(systems.certificates().iter().cloned());
        }
        Err(error) => warn!(%path, %error, "cannot read the system's certificate authorities"),
    }
    store
}

#[cfg(test)]
mod tests {
    use super::judged;
    use player::Clock;
    use rustls::pki_types::UnixTime;
    use rustls::{CertificateError, Error};
    use std::cell::RefCell;
    use std::time::Duration;

    const DAY_S: u64 = 86_400;

    /// The times at which a chain is tried whose certificates are valid from `from` on, in days, and until day `until`; and
    /// whether it is accepted.
    fn tried(clock: Clock, from: &[u64], until: u64) -> (Vec<u64>, bool) {
        let days = RefCell::new(Vec::new());
        let day = |day: u64| UnixTime::since_unix_epoch(Duration::from_secs(day * DAY_S));
        let judge = |at: UnixTime| {
            days.borrow_mut().push(at.as_secs() / DAY_S);
            let wrong = if let Some(begin) = from.iter().copied().find(|begin| day(*begin) > at) {
                CertificateError::NotValidYetContext { time: at, not_before: day(begin) }
            } else if at > day(until) {
                CertificateError::ExpiredContext { time: at, not_after: day(until) }
            } else {
                return Ok(());
            };
            Err(Error::InvalidCertificate(wrong))
        };
        let is_accepted = judged(&clock, judge).is_ok();
        (days.into_inner(), is_accepted)
    }

    #[test]
    fn the_dates_of_certificates_are_judged_by_what_is_known_of_the_time() {
        let clock = |shown: u64, is_synchronised| Clock {
            shown_s: shown * DAY_S,
            up_s: 0,
            earliest_s: 100 * DAY_S,
            is_synchronised,
        };
        for is_set in [false, true] {
            assert_eq!(tried(clock(200, is_set), &[150], 300), (vec![200], true), "valid");
            assert_eq!(tried(clock(200, is_set), &[150], 199), (vec![200], false), "expired");
            assert_eq!(tried(clock(0, is_set), &[0], 99), (vec![100], false), "expired before the system was made");
            assert_eq!(tried(clock(0, is_set), &[0], 101), (vec![100], true), "by the date of the system");
        }
        assert_eq!(tried(clock(200, true), &[250], 300), (vec![200], false), "not valid yet, by a clock that was set");
        assert_eq!(tried(clock(200, false), &[250], 300), (vec![200, 250], true), "the clock may be behind");
        assert_eq!(tried(clock(0, false), &[150, 250], 300), (vec![100, 150, 250], true), "each later than the other");
        assert_eq!(tried(clock(0, false), &[250, 150], 200), (vec![100, 250], false), "never valid all at once");
        let endless: Vec<_> = (101..200).collect();
        assert!(!tried(clock(0, false), &endless, 300).1, "nobody's chain is that long");
    }
}
