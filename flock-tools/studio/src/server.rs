//! The sockets, and how long a connection may take.
//!
//! Owns that only this machine is listened to, and how long a connection may be silent. Never judges a request: `fence`
//! does, and `connections` knows which connection makes room for another.
//!
//! Start at [`Server::bind`].

use std::future::Future;
use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, TcpListener as StdListener};
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use crate::connections::{Connections, Place};

/// The longest time until a connection has sent the head of its next request.
const LONGEST_HEAD: Duration = Duration::from_secs(30);
/// The most bytes of a head.
const MOST_HEAD_BYTES: usize = 32 << 10;
/// How long what is being answered may take once the server is to end.
const LAST_ANSWERS: Duration = Duration::from_millis(500);
/// How long nothing is accepted after the system could not.
const REST: Duration = Duration::from_millis(100);
/// How often another port is tried, if the one that the system gave is taken on the other address.
const TRIES: usize = 16;

/// A server that is bound and not yet answering.
#[derive(Debug)]
pub(crate) struct Server {
    listeners: Vec<StdListener>,
    port: u16,
}

/// What the system does not give.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StudioError {
    #[error("cannot listen at port {port} of this machine")]
    Bind { port: u16, source: io::Error },
    #[error("cannot start the studio")]
    Start { source: io::Error },
}

impl Server {
    /// Takes `port` of this machine's own addresses, of IPv4 and, where there is one, of IPv6; 0 is any that is free.
    /// Errors: If the port is taken.
    pub(crate) fn bind(port: u16) -> io::Result<Self> {
        let mut last = io::Error::from(io::ErrorKind::AddrInUse);
        for _ in 0..TRIES {
            let four = StdListener::bind((Ipv4Addr::LOCALHOST, port))?;
            let own = four.local_addr()?.port();
            let six = StdListener::bind((Ipv6Addr::LOCALHOST, own));
            match six {
                Ok(six) => return Self::of(vec![four, six], own),
                Err(error) if error.kind() == io::ErrorKind::AddrInUse && port == 0 => last = error,
                Err(error) if error.kind() == io::ErrorKind::AddrInUse => return Err(error),
                // A machine without IPv6.
                Err(_) => return Self::of(vec![four], own),
            }
        }
        Err(last)
    }

    fn of(listeners: Vec<StdListener>, port: u16) -> io::Result<Self> {
        listeners.iter().try_for_each(|listener| listener.set_nonblocking(true))?;
        Ok(Self { listeners, port })
    }

    /// Its port.
    pub(crate) fn port(&self) -> u16 {
        self.port
    }

    /// The threads for a server, and for what waits beside it: two.
    /// Errors: If the system gives no threads.
    pub(crate) fn runtime() -> io::Result<Runtime> {
        Builder::new_multi_thread().worker_threads(2).thread_name("page").enable_io().enable_time().build()
    }

    /// Answers with `router` until `stop` is there, then finishes what is being answered, for half a second.
    /// Errors: If the sockets cannot be used.
    pub(crate) async fn serve(self, router: Router, stop: impl Future<Output = ()> + Send + 'static) -> io::Result<()> {
        let (stopping, stopped) = watch::channel(false);
        let held = Arc::new(Connections::default());
        let mut accepting = JoinSet::new();
        for listener in self.listeners {
            let listener = TcpListener::from_std(listener)?;
            accepting.spawn(accept(listener, router.clone(), Arc::clone(&held), stopped.clone()));
        }
        stop.await;
        // The receivers are in the tasks, which may all be over.
        let _ = stopping.send(true);
        // What takes longer is cut off.
        let _ = timeout(LAST_ANSWERS, async { while accepting.join_next().await.is_some() {} }).await;
        Ok(())
    }
}

/// Accepts connections until the server is to end; then waits for those that are being answered.
async fn accept(listener: TcpListener, router: Router, held: Arc<Connections>, mut stopped: watch::Receiver<bool>) {
    let mut connections = JoinSet::new();
    loop {
        let stream = tokio::select! {
            accepted = listener.accept() => accepted.map(|(stream, _)| stream),
            _ = stopped.wait_for(|stop| *stop) => break,
        };
        while connections.try_join_next().is_some() {}
        let Ok(stream) = stream else {
            // Such as without a free descriptor: soon there may be one.
            sleep(REST).await;
            continue;
        };
        connections.spawn(answer(stream, router.clone(), held.enter(), stopped.clone()));
    }
    while connections.join_next().await.is_some() {}
}

async fn answer(stream: TcpStream, router: Router, place: Arc<Place>, mut stopped: watch::Receiver<bool>) {
    // A small answer is not held back for the next one.
    let _ = stream.set_nodelay(true);
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(LONGEST_HEAD).max_buf_size(MOST_HEAD_BYTES);
    let (inside, own) = (TowerToHyperService::new(router), Arc::clone(&place));
    let service = service_fn(move |mut request: Request<Incoming>| {
        own.heard();
        request.extensions_mut().insert(Arc::clone(&own));
        inside.call(request)
    });
    let connection = http.serve_connection(TokioIo::new(stream), service);
    let mut connection = std::pin::pin!(connection);
    // What goes wrong on a connection is the other end's: it is closed.
    tokio::select! {
        _ = connection.as_mut() => return,
        () = place.needed() => return,
        _ = stopped.wait_for(|stop| *stop) => connection.as_mut().graceful_shutdown(),
    }
    let _ = connection.await;
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Server {
        /// The addresses that it listens at.
        /// Errors: What the system says.
        pub(crate) fn addresses(&self) -> io::Result<Vec<std::net::SocketAddr>> {
            self.listeners.iter().map(StdListener::local_addr).collect()
        }
    }
}
