//! A broker, its subscribers, and how the instrument comes and goes.

use crate::bench::{PATIENCE, Run, Running, Tested, free, program, wait_for, wait_until};
use publish::feed::{FeedEvent, FeedEventKind, FeedItem};
use std::error::Error;
use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::Path;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::SystemTime;

const TOPICS: &str = "anemo/000000010000000200000003";

/// mosquitto with more lines of configuration.
fn broker(folder: &Path, address: SocketAddr, more: &str) -> Result<Option<Running>, Box<dyn Error>> {
    let Some(mosquitto) = program("mosquitto") else { return Ok(None) };
    let config = folder.join("mosquitto.conf");
    // It would not stay root, and the folder is ours alone.
    let text = format!("user root\nlistener {} 127.0.0.1\npersistence false\n{more}\n", address.port());
    std::fs::write(&config, text)?;
    let running = Running::start(Command::new(mosquitto).arg("-c").arg(&config))?;
    wait_for(address)?;
    Ok(Some(running))
}

/// Messages that a subscriber to everything hears: `topic message`, one a line.
struct Subscriber {
    _program: Running,
    heard: Arc<Mutex<Vec<String>>>,
}

impl Subscriber {
    fn start(address: SocketAddr, options: &[&str]) -> Result<Option<Self>, Box<dyn Error>> {
        let Some(program) = program("mosquitto_sub") else { return Ok(None) };
        let port = address.port().to_string();
        let mut command = Command::new(program);
        command.args(["-h", "127.0.0.1", "-p", &port, "-t", "#", "-F", "%t %r %p"]).args(options);
        let mut running = Running::start(&mut command)?;
        let stdout = running.0.stdout.take().ok_or("it has an output")?;
        let heard = Arc::new(Mutex::new(Vec::new()));
        let into = heard.clone();
        std::thread::spawn(move || {
            for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                into.lock().expect("no panic").push(line);
            }
        });
        Ok(Some(Self { _program: running, heard }))
    }

    fn wait_for(&self, start: &str) -> Result<String, Box<dyn Error>> {
        let find = || self.heard.lock().expect("no panic").iter().find(|line| line.starts_with(start)).cloned();
        wait_until(&format!("`{start}` is heard"), || find().is_some())?;
        find().ok_or_else(|| "it was heard".into())
    }
}

#[test]
fn a_broker_keeps_state_and_discovery_for_who_comes_later() -> Tested {
    let (folder, address) = (tempfile::tempdir()?, free()?);
    let Some(_broker) = broker(folder.path(), address, "allow_anonymous true")? else { return Ok(()) };
    let run = Run::start(&format!("mqtt://{address}?every=0.1"))?;
    let Some(early) = Subscriber::start(address, &[])? else { return Ok(()) };
    early.wait_for(&format!("{TOPICS}/state 0 "))?;
    // Who comes later gets it as kept (`%r` is 1), at once.
    let Some(late) = Subscriber::start(address, &[])? else { return Ok(()) };
    late.wait_for(&format!("{TOPICS}/status 1 online"))?;
    let state = late.wait_for(&format!("{TOPICS}/state 1 "))?;
    for part in ["\"wind_speed_m_s\":2.5", "\"wind_from_deg\":270", "\"state\":\"running\""] {
        assert!(state.contains(part), "{state}");
    }
    let document = late.wait_for("homeassistant/device/anemo_000000010000000200000003/config 1 ")?;
    let (_, document) = document.split_once(" 1 ").ok_or("a message")?;
    let document: serde_json::Value = serde_json::from_str(document)?;
    assert_eq!(document["components"]["wind_from_deg"]["state_class"], "measurement_angle");

    let trip = FeedEventKind::Trip { cause: "open".to_owned(), element: Some("core".to_owned()) };
    run.feed.push(&FeedItem::Event(FeedEvent { time_s: 1.0, utc: SystemTime::now(), kind: trip }));
    assert!(late.wait_for(&format!("{TOPICS}/event 0 "))?.contains("trip: open of core"));
    assert!(run.end().is_empty());
    late.wait_for(&format!("{TOPICS}/status 0 offline"))?;
    Ok(())
}

#[test]
fn a_broker_that_is_not_there_costs_two_sentences() -> Tested {
    let (folder, address) = (tempfile::tempdir()?, free()?);
    if program("mosquitto").is_none() {
        return Ok(());
    }
    let run = Run::start(&format!("mqtt://{address}?every=0.1"))?;
    wait_until("it has failed", || run.has_said("the recording goes on, trying again"))?;
    let broker_ = broker(folder.path(), address, "allow_anonymous true")?;
    wait_until("it works", || run.has_said("works again"))?;
    drop(broker_);
    wait_until("it has failed again", || run.sentences.lock().expect("no panic").len() == 3)?;
    assert!(run.end().is_empty());
    Ok(())
}

#[test]
fn a_wrong_password_is_named_and_the_right_one_works() -> Tested {
    let (folder, address) = (tempfile::tempdir()?, free()?);
    let Some(passwd) = program("mosquitto_passwd") else { return Ok(()) };
    let file = folder.path().join("passwords");
    let made = Running::start(Command::new(passwd).args(["-b", "-c"]).arg(&file).args(["mast", "north"]))?;
    made.printed()?;
    let more = format!("allow_anonymous false\npassword_file {}", file.display());
    let Some(_broker) = broker(folder.path(), address, &more)? else { return Ok(()) };
    let wrong = Run::start(&format!("mqtt://mast:south@{address}"))?;
    wait_until("it is refused", || wrong.has_said("the broker refuses: user or password are wrong"))?;
    assert!(wrong.end().is_empty());
    let right = Run::start(&format!("mqtt://mast:north@{address}"))?;
    let Some(subscriber) = Subscriber::start(address, &["-u", "mast", "-P", "north"])? else { return Ok(()) };
    subscriber.wait_for(&format!("{TOPICS}/status"))?;
    assert!(right.end().is_empty());
    Ok(())
}

const CHILD: &str = "ANEMO_TEST_BROKER";

/// The program that the next test kills.
#[test]
fn publishes_where_the_environment_says() -> Tested {
    let Some(address) = std::env::var_os(CHILD) else { return Ok(()) };
    let _run = Run::start(&format!("mqtt://{}", address.to_string_lossy()))?;
    std::thread::sleep(PATIENCE);
    Ok(())
}

#[test]
fn the_last_will_of_a_program_that_was_killed_is_offline() -> Tested {
    let (folder, address) = (tempfile::tempdir()?, free()?);
    let Some(_broker) = broker(folder.path(), address, "allow_anonymous true")? else { return Ok(()) };
    let Some(subscriber) = Subscriber::start(address, &[])? else { return Ok(()) };
    let mut child = Command::new(std::env::current_exe()?);
    child.args(["--exact", "mqtt::publishes_where_the_environment_says"]).env(CHILD, address.to_string());
    let child = Running::start(&mut child)?;
    // Kept (1) if the program was quicker than the subscriber.
    assert!(subscriber.wait_for(&format!("{TOPICS}/status"))?.ends_with(" online"));
    // Killed as the test's guard ends it: without a good-bye.
    drop(child);
    subscriber.wait_for(&format!("{TOPICS}/status 0 offline"))?;
    Ok(())
}

/// With certificates as openssl makes them. `cargo test -p publish --features tls`.
#[cfg(feature = "tls")]
#[test]
fn an_encrypted_connection_wants_the_right_authority() -> Tested {
    let (folder, address) = (tempfile::tempdir()?, free()?);
    let Some(openssl) = program("openssl") else { return Ok(()) };
    let at = |name: &str| folder.path().join(name);
    for name in ["broker", "other"] {
        let mut command = Command::new(&openssl);
        command.args(["req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]);
        command.args(["-days", "2", "-subj", "/CN=anemo test", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1"]);
        command.args(["-addext", "basicConstraints=critical,CA:FALSE"]);
        command.arg("-keyout").arg(at(&format!("{name}.key"))).arg("-out").arg(at(&format!("{name}.pem")));
        Running::start(&mut command)?.printed()?;
    }
    let more = format!(
        "allow_anonymous true\ncertfile {}\nkeyfile {}",
        at("broker.pem").display(),
        at("broker.key").display()
    );
    let Some(_broker) = broker(folder.path(), address, &more)? else { return Ok(()) };
    let target = |ca_file: &str| -> Result<String, Box<dyn Error>> {
        let file = at(&format!("{ca_file}.toml"));
        let text = format!("[[publish]]\nto = \"mqtts://localhost:{}\"\nca_file = \"{ca_file}.pem\"\n", address.port());
        std::fs::write(&file, text)?;
        Ok(file.display().to_string())
    };
    let wrong = Run::start(&target("other")?)?;
    wait_until("it is refused", || wrong.has_said("certificate"))?;
    assert!(wrong.end().is_empty());
    let right = Run::start(&target("broker")?)?;
    let certificate = at("broker.pem").display().to_string();
    let Some(subscriber) = Subscriber::start(address, &["--cafile", &certificate])? else { return Ok(()) };
    subscriber.wait_for(&format!("{TOPICS}/state"))?;
    assert!(right.end().is_empty());
    Ok(())
}
