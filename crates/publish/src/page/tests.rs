//! The page's server, asked as a browser asks it: on the loopback, in this process.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use serde_json::Value;

use super::LivePage;
use crate::commands::{CommandRefusal, FeedCommand, FeedCommands, channel};
use crate::feed::{Feed, FeedEvent, FeedEventKind, FeedItem, FeedLayout, FeedRow};
use crate::listen::{Listening, Token};

/// A page may be this late with a trip.
const TRIP_S: f64 = 0.5;

fn feed() -> Feed {
    Feed::new(FeedLayout {
        title: "Gusts".to_owned(),
        elements: ["left", "right"].map(str::to_owned).to_vec(),
        sample_period_s: 0.001,
        ..FeedLayout::default()
    })
}

fn row(n: u32, state: &str, temperature_c: f32) -> FeedItem {
    FeedItem::Row(Arc::new(FeedRow {
        time_s: f64::from(n) * 0.001,
        utc: SystemTime::UNIX_EPOCH,
        temperature_c: vec![temperature_c, -20.0],
        power_w: vec![0.01, f32::NAN],
        equivalent_power_w: Vec::new(),
        heaters: 1,
        state: state.into(),
        wind: None,
        true_wind_m_s: None,
        gas_temperature_c: None,
    }))
}

fn trip() -> FeedItem {
    let kind = FeedEventKind::Trip { cause: "open".to_owned(), element: Some("left".to_owned()) };
    FeedItem::Event(FeedEvent { time_s: 0.0, utc: SystemTime::UNIX_EPOCH, kind })
}

fn serve(feed: &Feed, commands: Option<FeedCommands>) -> LivePage {
    let listening = Listening::new(None, Token::random().unwrap());
    LivePage::serve(feed, commands, &listening, ([127, 0, 0, 1], 0).into()).unwrap()
}

fn page(feed: &Feed) -> LivePage {
    serve(feed, None)
}

/// Host and path of the page.
fn parts(page: &LivePage) -> (&str, &str) {
    let (host, path) = page.address().strip_prefix("http://").unwrap().split_once('/').unwrap();
    (host, path)
}

/// Sends a request, with these headers in place of a browser's own.
fn send(page: &LivePage, method: &str, path: &str, headers: &[&str], body: &str) -> TcpStream {
    let (host, _) = parts(page);
    let mut stream = TcpStream::connect(host).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    let own_host = format!("Host: {host}");
    let host = if headers.iter().any(|line| line.starts_with("Host:")) { None } else { Some(own_host.as_str()) };
    let lines: Vec<&str> = host.into_iter().chain(headers.iter().copied()).collect();
    let (lines, length) = (lines.join("\r\n"), body.len());
    write!(stream, "{method} {path} HTTP/1.1\r\n{lines}\r\nContent-Length: {length}\r\n\r\n{body}").unwrap();
    stream
}

/// Status and body.
fn ask(page: &LivePage, method: &str, path: &str, headers: &[&str], body: &str) -> (u16, String) {
    let mut text = String::new();
    send(page, method, path, headers, body).read_to_string(&mut text).unwrap();
    let status = text.split(' ').nth(1).unwrap().parse().unwrap();
    (status, text.split_once("\r\n\r\n").unwrap().1.to_owned())
}

/// The server-sent events of a page, one by one.
fn events(page: &LivePage, query: &str) -> impl Iterator<Item = (String, Value)> + use<> {
    let stream = send(page, "GET", &format!("/{}events?{query}", parts(page).1), &[], "");
    let mut lines = BufReader::new(stream).lines().map_while(Result::ok);
    std::iter::from_fn(move || {
        let name = lines.find_map(|line| line.strip_prefix("event: ").map(str::to_owned))?;
        let data = lines.next()?;
        Some((name, serde_json::from_str(data.strip_prefix("data: ")?).unwrap()))
    })
}

#[test]
fn the_page_draws_the_rows_of_the_feed() {
    let feed = feed();
    let page = page(&feed);
    let (status, text) = ask(&page, "GET", &format!("/{}", parts(&page).1), &[], "");
    assert!(status == 200 && text.starts_with("<!doctype html>") && text.contains("uPlot"));
    // One sample of 3 000 stands out, for a thousandth of a second.
    (0..3000).for_each(|n| feed.push(&row(n, "running", if n == 1234 { 99.0 } else { 20.0 })));
    let mut events = events(&page, "window_s=60");
    let (name, layout) = events.next().unwrap();
    assert_eq!(
        (name.as_str(), layout["elements"][1].as_str(), layout["commands"].as_bool()),
        ("layout", Some("right"), Some(false))
    );
    let channel =
        |name: &str| layout["channels"].as_array().unwrap().iter().position(|own| own["name"] == name).unwrap();
    let (left, power) = (channel("temperature left"), channel("power right"));
    let (mut buckets, mut last) = (std::collections::BTreeMap::new(), -1.0);
    while last < 2.9985 {
        let (name, rows) = events.next().unwrap();
        if name == "rows" {
            last = rows["time_s"].as_f64().unwrap();
            for bucket in rows["buckets"].as_array().unwrap() {
                buckets.insert(bucket["id"].as_i64().unwrap(), bucket.clone());
            }
        }
    }
    assert_eq!(buckets.len(), 30);
    assert_eq!((buckets[&12]["high"][left].as_f64(), buckets[&12]["low"][left].as_f64()), (Some(99.0), Some(20.0)));
    assert!(buckets.iter().all(|(&id, bucket)| id == 12 || bucket["high"][left] == 20.0));
    assert!(buckets[&3]["mean"][power].is_null(), "no number is drawn as none");
    let spectrum = events.find(|(name, _)| name == "spectrum").unwrap().1;
    assert!(spectrum["density"].as_array().unwrap().len() > 20 && spectrum["unit"] == "K");
}

#[test]
fn who_lacks_the_token_or_asks_from_elsewhere_is_refused() {
    let feed = feed();
    let page = page(&feed);
    let (host, path) = parts(&page);
    let (port, path) = (host.split_once(':').unwrap().1, format!("/{path}"));
    let status = |path: &str, headers: &[&str]| ask(&page, "GET", path, headers, "").0;
    let evil = format!("Host: evil.example:{port}");
    assert_eq!([status("/", &[]), status("/0123/", &[]), status(&path[..path.len() - 2], &[])], [403; 3]);
    assert_eq!([status(&path, &[&evil]), status(&path, &["Host: 127.0.0.1"]), status(&path, &["Host:"])], [403; 3]);
    assert_eq!([status(&path, &["Origin: http://evil.example"]), status(&path, &["Origin: null"])], [403; 2]);
    assert_eq!(status(&path, &[&format!("Host: localhost:{port}")]), 200);
    assert_eq!(status(&path, &[&format!("Origin: http://{host}")]), 200);
    assert_eq!(status(&format!("{path}nothing"), &[]), 404);
}

#[test]
fn a_trip_is_told_half_a_second_after_its_tick_at_the_latest() {
    let feed = feed();
    let page = page(&feed);
    feed.push(&row(0, "running", 20.0));
    let mut events = events(&page, "");
    assert_eq!(events.next().unwrap().0, "layout");
    assert_eq!(events.find(|(name, _)| name == "rows").unwrap().1["trip"], Value::Null);
    let begun = Instant::now();
    feed.push(&row(1, "tripped:open:left", 20.0));
    feed.push(&trip());
    let told = events.find(|(name, _)| name == "event").unwrap().1;
    let rows = events.find(|(name, data)| name == "rows" && !data["trip"].is_null()).unwrap().1;
    assert!(begun.elapsed().as_secs_f64() < TRIP_S, "{:?}", begun.elapsed());
    assert_eq!((told["text"].as_str(), rows["trip"].as_str()), (Some("tripped: open, left"), Some("open, left")));
    // Acknowledged, it is over.
    feed.push(&row(2, "standby", 20.0));
    assert!(events.any(|(name, data)| name == "rows" && data["trip"].is_null()));
}

#[test]
fn lost_samples_are_counted_and_a_page_learns_that_the_run_is_over() {
    let feed = feed();
    let page = page(&feed);
    [0, 1, 2, 13, 14].into_iter().for_each(|n| feed.push(&row(n, "running", 20.0)));
    let mut events = events(&page, "");
    assert_eq!(events.find(|(name, data)| name == "rows" && data["time_s"] == 0.014).unwrap().1["lost"], 10);
    drop(feed);
    assert_eq!(events.last().unwrap().0, "ended");
}

#[test]
fn commands_are_carried_out_by_the_run_or_refused_by_its_sentence() {
    let feed = feed();
    let (commands, requests) = channel();
    let page = serve(&feed, Some(commands));
    let run = std::thread::spawn(move || {
        let asked = requests.iter().take(2).map(|request| {
            let command = request.command.clone();
            request.answer(if command == FeedCommand::Start {
                Err(CommandRefusal("not armed".to_owned()))
            } else {
                Ok(())
            });
            command
        });
        asked.collect::<Vec<_>>()
    });
    let path = format!("/{}command", parts(&page).1);
    let command = |headers: &[&str], body: &str| ask(&page, "POST", &path, headers, body);
    let json = ["Content-Type: application/json"];
    assert_eq!(command(&json, "\"start\""), (409, r#"{"refused":"not armed"}"#.to_owned()));
    let set = command(&json, r#"{"set_point":{"element":"left","temperature_c":-12.5}}"#);
    assert_eq!(set, (200, r#"{"done":"Set-point of left: -12.5 °C."}"#.to_owned()));
    let set = FeedCommand::SetPoint { element: "left".to_owned(), temperature_c: -12.5 };
    assert_eq!(run.join().unwrap(), [FeedCommand::Start, set]);
    // A foreign command does not reach the run.
    for (headers, body) in [(&json[..], "{}"), (&json, "\"heat\""), (&[], "\"stop\"")] {
        assert_eq!(command(headers, body).0, 409, "{body}");
    }
}

#[test]
fn a_listener_that_does_not_read_holds_nobody_up() {
    let feed = feed();
    let page = page(&feed);
    let _asleep = send(&page, "GET", &format!("/{}events", parts(&page).1), &[], "");
    let begun = Instant::now();
    (0..100_000).for_each(|n| feed.push(&row(n, "running", 20.0)));
    assert!(begun.elapsed() < Duration::from_secs(5), "{:?}", begun.elapsed());
    let (_, rows) = events(&page, "").find(|(name, _)| name == "rows").unwrap();
    assert!(rows["time_s"].as_f64().is_some());
}
