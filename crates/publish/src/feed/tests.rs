use super::*;

const SOON: Duration = Duration::from_millis(1);

fn row(time_s: f64) -> FeedItem {
    FeedItem::Row(Arc::new(FeedRow {
        time_s,
        utc: SystemTime::UNIX_EPOCH,
        temperature_c: vec![60.0],
        power_w: vec![0.1],
        equivalent_power_w: vec![],
        heaters: 1,
        state: "running".into(),
        wind: None,
        true_wind_m_s: None,
        gas_temperature_c: None,
    }))
}

fn event(kind: FeedEventKind) -> FeedItem {
    FeedItem::Event(FeedEvent { time_s: 0.0, utc: SystemTime::UNIX_EPOCH, kind })
}

#[test]
fn a_slow_reader_loses_its_oldest_rows_and_knows_how_many() {
    let feed = Feed::new(FeedLayout::default());
    let (slow, quick) = (feed.subscribe(3), feed.subscribe(100));
    for tick in 0..10 {
        feed.push(&row(f64::from(tick)));
    }
    assert_eq!((slow.lost(), quick.lost()), (7, 0));
    for tick in 7..10 {
        assert_eq!(slow.recv_timeout(SOON), Ok(row(f64::from(tick))));
    }
    assert_eq!(slow.recv_timeout(SOON), Err(RecvTimeoutError::Timeout));
    assert_eq!(quick.recv_timeout(SOON), Ok(row(0.0)));
}

#[test]
fn an_event_outlives_rows_but_not_without_end() {
    let feed = Feed::new(FeedLayout::default());
    let reader = feed.subscribe(2);
    let trip = event(FeedEventKind::Trip { cause: "open".to_owned(), element: None });
    feed.push(&trip);
    for tick in 0..5 {
        feed.push(&row(f64::from(tick)));
    }
    assert_eq!(reader.recv_timeout(SOON), Ok(trip));
    assert_eq!(reader.recv_timeout(SOON), Ok(row(4.0)));
    for _ in 0..5 {
        feed.push(&event(FeedEventKind::LinkBack));
    }
    assert_eq!(reader.lost(), 4 + 3);
}

#[test]
fn a_reader_gets_the_rest_of_a_feed_that_ended_and_a_lost_reader_is_forgotten() {
    let feed = Feed::new(FeedLayout::default());
    let reader = feed.subscribe(2);
    drop(feed.subscribe(2));
    feed.push(&row(1.0));
    assert_eq!(lock(&feed.0.queues).len(), 1);
    drop(feed);
    assert_eq!(reader.recv_timeout(SOON), Ok(row(1.0)));
    assert_eq!(reader.recv_timeout(SOON), Err(RecvTimeoutError::Disconnected));
}

#[test]
fn a_reader_that_waits_wakes_and_one_that_sleeps_holds_nobody_up() {
    let feed = Feed::new(FeedLayout::default());
    let (waiting, _sleeping) = (feed.subscribe(4), feed.subscribe(1));
    std::thread::scope(|scope| {
        let woken = scope.spawn(move || waiting.recv_timeout(Duration::from_secs(60)));
        let start = Instant::now();
        for tick in 0..10_000 {
            feed.push(&row(f64::from(tick)));
        }
        assert!(woken.join().expect("no panic").is_ok());
        // Ten seconds of a run at 1 kHz; some microseconds each even on a busy machine.
        assert!(start.elapsed() < Duration::from_secs(5));
    });
}
