//! What a page is told, however often it is cut off.
//! The last claim has the stream over a real connection.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::Duration;

use serde_json::json;
use tokio::sync::oneshot;

use super::{Event, EventKind, Hub, KEPT, Subscription};
use crate::server::Server;

/// All that a page is told at once.
fn told(page: &mut Subscription) -> Vec<Event> {
    std::iter::from_fn(|| page.at_once()).collect()
}

fn kinds(events: &[Event]) -> Vec<&'static str> {
    events.iter().map(|event| event.kind.name()).collect()
}

fn note(hub: &Hub, number: usize) {
    hub.send(EventKind::Note, &json!({ "text": number }));
}

#[test]
fn a_new_page_fetches_everything_first_and_then_hears_each_event_once() {
    let hub = Arc::new(Hub::new(7));
    note(&hub, 0);
    let mut page = hub.subscribe(None);
    assert_eq!(kinds(&told(&mut page)), ["state"]);
    note(&hub, 1);
    hub.send(EventKind::Changed, &json!({}));
    assert_eq!(kinds(&told(&mut page)), ["note", "changed"]);
    assert_eq!(told(&mut page), []);
}

#[test]
fn a_page_that_comes_back_is_told_what_it_missed_and_nothing_twice() {
    let hub = Arc::new(Hub::new(7));
    let mut page = hub.subscribe(None);
    note(&hub, 1);
    let last = told(&mut page).pop().unwrap().id;
    drop(page);
    for number in 2..5 {
        note(&hub, number);
    }
    let missed = told(&mut hub.subscribe(Some(&last)));
    let data: Vec<_> = missed.iter().map(|event| event.data.to_string()).collect();
    assert_eq!(data, [r#"{"text":2}"#, r#"{"text":3}"#, r#"{"text":4}"#]);
    let newest = &missed.last().unwrap().id;
    assert_eq!(told(&mut hub.subscribe(Some(newest))), []);
}

#[test]
fn a_page_that_missed_too_much_or_knows_another_start_fetches_everything() {
    let hub = Arc::new(Hub::new(7));
    let mut slow = hub.subscribe(None);
    let first = told(&mut slow).pop().unwrap().id;
    for number in 0..KEPT {
        note(&hub, number);
    }
    assert_eq!(told(&mut hub.subscribe(Some(&first))).len(), KEPT, "just not too much");
    note(&hub, KEPT);
    assert_eq!(kinds(&told(&mut slow)), ["state"]);
    for id in [first.as_str(), "8-3", "7-99999", "7", "", "7-x", "-1"] {
        assert_eq!(kinds(&told(&mut hub.subscribe(Some(id)))), ["state"], "{id}");
    }
}

#[test]
fn a_page_that_waits_is_woken() {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).build().unwrap();
    let hub = Arc::new(Hub::new(1));
    let mut page = hub.subscribe(None);
    told(&mut page);
    let waits = runtime.spawn(async move { page.next().await });
    note(&hub, 3);
    let event = runtime.block_on(waits).unwrap();
    assert_eq!((event.kind, &*event.data), (EventKind::Note, r#"{"text":3}"#));
}

/// Opens the stream of the server at `port`.
fn listen(port: u16, last: &str) -> BufReader<TcpStream> {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    write!(stream, "GET /events HTTP/1.1\r\nHost: x\r\nLast-Event-ID: {last}\r\n\r\n").unwrap();
    BufReader::new(stream)
}

/// The next lines of a stream that begin with these words.
fn heard(stream: &mut BufReader<TcpStream>, words: &[&str]) -> Vec<String> {
    let mut lines = stream.lines().map(|line| line.expect("the stream goes on"));
    words.iter().map(|word| lines.find(|line| line.starts_with(word)).expect("the stream goes on")).collect()
}

#[test]
fn a_stream_over_a_connection_goes_on_at_the_next_and_ends_with_the_server() {
    let (server, hub) = (Server::bind(0).unwrap(), Arc::new(Hub::new(0xab)));
    let (port, runtime) = (server.port(), Server::runtime().unwrap());
    assert!(server.addresses().unwrap().iter().all(|address| address.ip().is_loopback()));
    let (stop, stopped) = oneshot::channel::<()>();
    let serving = runtime.spawn(server.serve(Arc::clone(&hub).router(), async { drop(stopped.await) }));
    let mut first = listen(port, "");
    assert_eq!(heard(&mut first, &["id:", "event:"]), ["id: ab-0", "event: state"]);
    note(&hub, 1);
    assert_eq!(heard(&mut first, &["id:", "event:", "data:"]), ["id: ab-1", "event: note", r#"data: {"text":1}"#]);
    drop(first);
    note(&hub, 2);
    let mut second = listen(port, "ab-1");
    assert_eq!(heard(&mut second, &["id:"]), ["id: ab-2"]);
    stop.send(()).unwrap();
    runtime.block_on(serving).unwrap().unwrap();
    // However it is cut off, it is over.
    let _ = second.read_to_end(&mut Vec::new());
    assert!(TcpStream::connect(("127.0.0.1", port)).is_err());
}
