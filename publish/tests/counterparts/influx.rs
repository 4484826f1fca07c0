//! InfluxDB takes what is sent, and gives it back.

use crate::bench::{Run, Running, Tested, free, program, wait_for, wait_until};
use publish::feed::{FeedEvent, FeedEventKind, FeedItem};
use std::process::Command;
use std::time::SystemTime;

#[test]
fn influx_keeps_numbers_texts_and_events() -> Tested {
    let Some(influxd) = program("influxd") else { return Ok(()) };
    let (folder, http, own, udp) = (tempfile::tempdir()?, free()?, free()?, free()?);
    let at = folder.path().display();
    let config = folder.path().join("influx.conf");
    std::fs::write(
        &config,
        format!(
            "reporting-disabled = true\nbind-address = \"{own}\"\n[meta]\ndir = \"{at}/meta\"\n[data]\ndir = \"{at}/data\"\nwal-dir = \"{at}/wal\"\n[http]\nbind-address = \"{http}\"\n[[udp]]\nenabled = true\nbind-address = \"{udp}\"\ndatabase = \"mast\"\nbatch-timeout = \"100ms\"\n"
        ),
    )?;
    let _server = Running::start(Command::new(influxd).arg("-config").arg(&config))?;
    wait_for(http)?;
    let query = |query: &str| -> Result<String, ureq::Error> {
        let url = format!("http://{http}/query?db=mast&epoch=ns&q={}", query.replace(' ', "%20"));
        ureq::post(&url).send_empty()?.body_mut().read_to_string()
    };
    query("CREATE DATABASE mast")?;
    let posted = Run::start(&format!("influx+http://{http}/write?db=mast&every=0"))?;
    let kind = FeedEventKind::Mark { text: "door \"opened\"\nx=1".to_owned() };
    let marked = FeedItem::Event(FeedEvent { time_s: 1.0, utc: SystemTime::now(), kind });
    wait_until("rows are there", || {
        // The output may not have been open for the first.
        posted.feed.push(&marked);
        let rows = query("SELECT * FROM anemo_event,anemo").unwrap_or_default();
        rows.contains("wind_from_deg") && rows.contains("door")
    })?;
    let rows = query("SELECT wind_speed_m_s,wind_from_deg,state,quality_flags,temperature_c_core FROM anemo LIMIT 1")?;
    // Of the reading that is no temperature there is no column.
    assert!(rows.contains(",2.5,270,\"running\",0,null]"), "{rows}");
    let tags = query("SHOW TAG VALUES FROM anemo WITH KEY = head")?;
    assert!(tags.contains("sphere, \\\"silver\\\""), "{tags}");
    let events = query("SELECT text FROM anemo_event LIMIT 1")?;
    assert!(events.contains("mark: door \\\"opened\\\" x=1"), "{events}");
    // A busy machine may be late, and rows are missed then; nothing is refused.
    assert!(!posted.has_said("answers with status"), "{:?}", posted.sentences);
    assert!(posted.end().is_empty());

    query("DROP MEASUREMENT anemo")?;
    let sent = Run::start(&format!("influx+udp://{udp}?every=0.1"))?;
    wait_until("datagrams are there", || query("SELECT * FROM anemo").is_ok_and(|rows| rows.contains("running")))?;
    assert!(sent.end().is_empty());
    Ok(())
}

#[test]
fn a_database_that_refuses_is_one_sentence() -> Tested {
    let Some(influxd) = program("influxd") else { return Ok(()) };
    let (folder, http, own) = (tempfile::tempdir()?, free()?, free()?);
    let at = folder.path().display();
    let config = folder.path().join("influx.conf");
    std::fs::write(
        &config,
        format!(
            "reporting-disabled = true\nbind-address = \"{own}\"\n[meta]\ndir = \"{at}/meta\"\n[data]\ndir = \"{at}/data\"\nwal-dir = \"{at}/wal\"\n[http]\nbind-address = \"{http}\"\n"
        ),
    )?;
    let _server = Running::start(Command::new(influxd).arg("-config").arg(&config))?;
    wait_for(http)?;
    let run = Run::start(&format!("influx+http://{http}/write?db=nowhere"))?;
    wait_until("it has failed", || run.has_said("answers with status 404; the recording goes on"))?;
    assert!(run.end().is_empty());
    Ok(())
}
