//! Recordings and models in a store of objects: a server of S3 on the loopback, and Python's own
//! client beside the command. `cargo xtask counterparts` brings both.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::process::{stdout, words};

const TIMEOUT: Duration = Duration::from_secs(60);

/// The folder of Python's programs, or a skip that is said.
fn programs() -> Option<PathBuf> {
    let programs = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../tools/counterparts/bin");
    if programs.join("moto_server").is_file() {
        return Some(programs);
    }
    let is_wanted = std::env::var_os("ANEMO_COUNTERPARTS").is_some_and(|wanted| wanted == "all");
    assert!(!is_wanted, "moto_server is absent: `cargo xtask counterparts` installs it");
    eprintln!("skipped: moto_server is absent (`cargo xtask counterparts` installs it)");
    None
}

/// A port that is free; nobody listens there by then.
#[allow(clippy::disallowed_types, reason = "asks for a port that is free, and hears nothing")]
fn free_port() -> u16 {
    std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// A store that ends with the test.
struct Store {
    server: Child,
    programs: PathBuf,
    folder: tempfile::TempDir,
    port: u16,
}

impl Drop for Store {
    fn drop(&mut self) {
        self.server.kill().and_then(|()| self.server.wait()).unwrap();
    }
}

impl Store {
    /// A server with the bucket `winds`; its log is the file `log`.
    fn start(command: impl FnOnce(&Path, &str) -> Command) -> Option<Self> {
        let (programs, folder, port) = (programs()?, tempfile::tempdir().unwrap(), free_port());
        let log = fs::File::create(folder.path().join("log")).unwrap();
        let mut command = command(&programs, &port.to_string());
        let server = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(log).spawn().unwrap();
        let store = Self { server, programs, folder, port };
        let deadline = Instant::now() + TIMEOUT;
        while !store.python("s3.create_bucket(Bucket='winds')").status.success() {
            assert!(Instant::now() < deadline, "the server does not answer: {}", store.log());
        }
        Some(store)
    }

    fn moto() -> Option<Self> {
        Self::start(|programs, port| {
            let mut server = Command::new(programs.join("moto_server"));
            server.args(["-H", "127.0.0.1", "-p", port]);
            server
        })
    }

    fn log(&self) -> String {
        fs::read_to_string(self.folder.path().join("log")).unwrap()
    }

    /// A program that finds the store.
    fn program(&self, program: &Path) -> Command {
        let mut command = Command::new(program);
        command.current_dir(self.folder.path()).env("AWS_ENDPOINT_URL", format!("http://127.0.0.1:{}", self.port));
        let own = [("AWS_ACCESS_KEY_ID", "reader"), ("AWS_SECRET_ACCESS_KEY", "secret"), ("AWS_REGION", "eu-west-3")];
        command.envs(own).env("AWS_DEFAULT_REGION", "us-east-1").env("TMPDIR", self.folder.path());
        command
    }

    /// Runs a line of Python with the client `s3`.
    fn python(&self, line: &str) -> Output {
        let begin = "import boto3, botocore.config; s3 = boto3.client('s3', config=botocore.config.Config(retries={'total_max_attempts': 1}))";
        self.program(&self.programs.join("python")).args(["-c", &format!("{begin}; {line}")]).output().unwrap()
    }

    fn anemo(&self, line: &str) -> Output {
        self.program(Path::new(env!("CARGO_BIN_EXE_anemo"))).args(words(line)).output().unwrap()
    }

    fn refused(&self, line: &str, code: i32) -> String {
        let output = self.anemo(line);
        assert_eq!(output.status.code(), Some(code), "{line}: {output:?}");
        String::from_utf8(output.stderr).unwrap().trim_end().to_owned()
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.folder.path().join(name)).unwrap()
    }
}

/// A body of one time constant, in parts; with as many digits as make the file long.
fn record(rows: std::ops::Range<usize>) -> String {
    let (mut seed, mut x, mut power_w) = (5_u64, 0.0, 0.0);
    let mut text = String::from("time_s,power_w,temperature_c\n");
    for row in 0..rows.end {
        if row % 12 == 0 {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            power_w = if seed >> 63 == 1 { 0.5 } else { 0.1 };
        }
        if rows.contains(&row) {
            text += &format!("{:.1},{power_w},{:.17}\n", 0.1 * row as f64, 20.0 + 30.0 * x);
        }
        x += (1.0 - (-0.1_f64 / 3.0).exp()) * (power_w - x);
    }
    text
}

#[test]
fn recordings_and_models_are_read_and_written_as_objects_by_the_name_of_the_bucket() {
    let Some(store) = Store::moto() else { return };
    let folder = store.folder.path();
    for (name, rows) in [("a.csv", 0..1500), ("b.csv", 1500..3000)] {
        fs::write(folder.join(name), record(rows)).unwrap();
    }
    let up = "[s3.upload_file(n, 'winds', 'run/' + n) for n in ('a.csv', 'b.csv')]";
    assert!(store.python(up).status.success());
    stdout(&store.anemo("identify a.csv b.csv -o files.json"));
    // As a pattern, and one by one; the model is an object itself.
    let parts = "identify s3://winds/run/a.csv s3://winds/run/b.csv -o s3://winds/models/parts.json --plot s3://winds/models/parts.svg";
    stdout(&store.anemo(parts));
    stdout(&store.anemo("identify s3://winds/r*n/?.csv -o pattern.json"));
    let down = "[s3.download_file('winds', 'models/' + n, n) for n in ('parts.json', 'parts.svg')]";
    assert!(store.python(down).status.success());
    let model = |name: &str| serde_json::from_slice::<serde_json::Value>(&store.read(name)).unwrap();
    for name in ["parts.json", "pattern.json"] {
        assert_eq!(model(name)["pairs"], model("files.json")["pairs"], "{name}");
    }
    assert!(String::from_utf8(store.read("parts.svg")).unwrap().contains("<svg"));
    // Its several readings fetched each object once for each of both commands.
    let fetched = store.log().lines().filter(|line| line.contains("GET /winds/run/a.csv")).count();
    assert_eq!(fetched, 2, "{}", store.log());
    stdout(&store.anemo("validate s3://winds/models/parts.json s3://winds/run/a.csv"));

    // An experiment names its head as a file does.
    let up = "[s3.upload_file(root + n, 'winds', n) for root in ('{root}',) for n in ('experiments/steady.toml', 'heads/sphere-b.toml', 'heads/models/sphere-b-mars-still.toml')]";
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../");
    assert!(store.python(&up.replace("{root}", root)).status.success());
    stdout(&store.anemo("check s3://winds/experiments/steady.toml"));

    // What is read is not written over; what is not there has the sentence of a file.
    let over = store.refused("reduce s3://winds/models/parts.json --order 1 -o s3://winds/models/parts.json", 2);
    assert!(over.contains("is read by this command"), "{over}");
    for (name, sentence) in [
        ("s3://winds/none.csv", "s3://winds/none.csv: there is no such file"),
        ("s3://nowhere/a.csv", "s3://nowhere/a.csv: there is no such file"),
        ("s3://winds/none-*.csv", "s3://winds/none-*.csv: no object has such a name"),
        ("s3://winds/run", "s3://winds/run: has no objects segment-*.parquet below it"),
        ("s3://winds", "s3://winds: cannot be read: it names no object"),
    ] {
        let refused = store.refused(&format!("identify {name}"), 2);
        assert!(refused.contains(sentence), "{refused}");
    }
    let nowhere = store.refused("reduce s3://winds/models/parts.json --order 1 -o s3://nowhere/reduced.json", 2);
    assert!(nowhere.contains("s3://nowhere/reduced.json: cannot be written: there is no such bucket"), "{nowhere}");
}

#[test]
fn long_objects_come_and_go_in_pieces_and_folders_of_segments_are_recordings() {
    let Some(store) = Store::moto() else { return };
    fs::write(store.folder.path().join("long.csv"), record(0..400_000)).unwrap();
    let up = "s3.upload_file('long.csv', 'winds', 'copied/segment-000001.csv', Config=__import__('boto3.s3.transfer').s3.transfer.TransferConfig(multipart_threshold=1 << 40))";
    assert!(store.python(up).status.success());
    stdout(&store.anemo("convert long.csv --start 2026-01-01T00:00:00Z -o here.dat"));
    stdout(&store.anemo("convert s3://winds/copied --start 2026-01-01T00:00:00Z -o s3://winds/there.dat"));
    let down = "s3.download_file('winds', 'there.dat', 'there.dat'); print(s3.head_object(Bucket='winds', Key='there.dat')['ETag'])";
    let tag = stdout(&store.python(down));
    assert!(store.read("here.dat").len() > 10_000_000 && store.read("here.dat") == store.read("there.dat"));
    // The tag of an object of several parts says so.
    let parts = store.read("there.dat").len().div_ceil(8 << 20);
    assert!(tag.contains(&format!("-{parts}\"")), "{tag}");
    let pieces = store.log().lines().filter(|line| line.contains("GET /winds/copied/segment-000001.csv")).count();
    assert_eq!(pieces, store.read("long.csv").len().div_ceil(8 << 20), "{}", store.log());
    // What is measured grows on a disk.
    let run = concat!("run ", env!("CARGO_MANIFEST_DIR"), "/../experiments/prbs.toml --on sim -o s3://winds/");
    stdout(&store.anemo(&format!("{run}prbs.parquet")));
    stdout(&store.anemo("identify s3://winds/prbs.parquet --output sector1 -o sector1.json"));
    let refused = store.refused(&format!("{run}prbs"), 2);
    assert!(refused.contains("an object does not grow"), "{refused}");
}

/// Whose bucket can be listed, but not be written.
const REFUSING: &str = "
import http.server, sys
class Refusing(http.server.BaseHTTPRequestHandler):
    def answer(self, code, body=b''):
        self.rfile.read(int(self.headers.get('Content-Length') or 0))
        self.send_response(code)
        self.send_header('Content-Length', str(len(body)))
        self.end_headers()
        self.wfile.write(body)
    def do_GET(self):
        self.answer(200, b'<ListBucketResult><Name>winds</Name><IsTruncated>false</IsTruncated></ListBucketResult>')
    def do_PUT(self):
        self.answer(200 if self.path == '/winds' else 403)
http.server.HTTPServer(('127.0.0.1', int(sys.argv[1])), Refusing).serve_forever()";

#[test]
fn what_a_store_does_not_take_is_kept_on_the_disk() {
    let Some(store) = Store::start(|programs, port| {
        let mut server = Command::new(programs.join("python"));
        server.args(["-c", REFUSING, port]);
        server
    }) else {
        return;
    };
    fs::write(store.folder.path().join("a.csv"), record(0..1500)).unwrap();
    stdout(&store.anemo("convert a.csv --start 2026-01-01T00:00:00Z -o here.dat"));
    let refused = store.refused("convert a.csv --start 2026-01-01T00:00:00Z -o s3://winds/a.dat", 1);
    assert!(refused.contains("s3://winds/a.dat: cannot be written: the store refuses it"), "{refused}");
    let kept = refused.split("it is kept as ").nth(1).unwrap().split(':').next().unwrap();
    assert!(fs::read(kept).unwrap() == store.read("here.dat"));
}

#[test]
fn a_store_that_is_none_is_said_in_time() {
    let begin = Instant::now();
    let nobody = format!("http://127.0.0.1:{}", free_port());
    let credentials: [(&str, &str); 2] = [("AWS_ACCESS_KEY_ID", "reader"), ("AWS_SECRET_ACCESS_KEY", "secret")];
    for (endpoint, credentials, name, sentence) in [
        (&nobody[..], &credentials[..], "s3://winds/a.csv", "the store does not answer"),
        ("nonsense", &credentials, "s3://winds/a.csv", "AWS_ENDPOINT_URL is `nonsense`: an address"),
        (&nobody, &credentials, "s3://w nds/a.csv", "it names no object: s3://bucket/name belongs here"),
        (&nobody, &credentials, "s3://winds//a.csv", "it names no object: s3"),
        (&nobody, &[], "s3://winds/a.csv", "there are no credentials"),
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_anemo"));
        let own = std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("AWS_"));
        for (name, _) in own {
            command.env_remove(name);
        }
        command.env("AWS_ENDPOINT_URL", endpoint).envs(credentials.iter().copied());
        let output = command.args(["identify", name]).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && said.contains(sentence), "{said}");
    }
    assert!(begin.elapsed() < TIMEOUT);
}
