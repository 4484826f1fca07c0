//! Images of the virtual board, run by QEMU and by this processor: the same exceptions in the same
//! order, and the same bytes.
//!
//! Both get the whole conversation as a file in place of the host's pipe, and nothing else that
//! happens in time: SysTick is left out here, and does not come there before the conversation is
//! over (`-icount`: 50 ms of virtual time are 50 million instructions).

use crate::rig;
use dr_core::Command as BoardCommand;
use dr_core::sensor::Reading;
use host_sim::experiment::Experiment;
use host_sim::instrument::LockStepController;
use host_sim::instrument::in_process::InProcess;
use host_sim::instrument::setup::ARM;
use host_sim::run::setup_of;
use silicon::image::FlashImage;
use silicon::processor::bus::{BusFault, MemoryJob, ProcessorBus};
use silicon::processor::fault::FaultStatus;
use silicon::processor::mpu::Mpu;
use silicon::processor::nvic::{ExceptionStep, Nvic, SYSTICK};
use silicon::processor::{Pause, Processor, SystemControl};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use wire::{MAX_FRAME, Provocation, Readings, ToBoard, encode};

const TO_BOARD: &str = "to-board.fifo";
const FROM_BOARD: &str = "from-board.fifo";
/// Cycles after which an image that does not end is given up.
const GIVEN_UP: u64 = 2_000_000_000;

const CORE_HZ: u64 = 168_000_000;

/// Peripherals of the virtual board beside its core: registers that read as zero, and transmitters
/// that are always ready, as in the emulator.
#[derive(Default)]
struct BareBoard {
    /// SysTick counts.
    ticks: bool,
    now: u64,
    system: SystemControl,
    attention: bool,
}

impl ProcessorBus for BareBoard {
    fn load(&mut self, address: u32, size: usize) -> Result<u32, BusFault> {
        const STATUS: [u32; 2] = [0x4001_1000, 0x4000_4400];
        const EMPTY_AND_SENT: u32 = 0xc0;
        if STATUS.contains(&address) {
            return Ok(EMPTY_AND_SENT);
        }
        if address < 0xe000_0000 {
            return Ok(0);
        }
        let word = self.system.load(address & !3, self.now, CORE_HZ)?;
        Ok(if size == 4 { word } else { word >> (8 * (address & 3)) & ((1 << (8 * size)) - 1) })
    }

    fn store(&mut self, address: u32, size: usize, value: u32) -> Result<(), BusFault> {
        if address >= 0xe000_0000 {
            self.system.store(address, size, value, self.now, CORE_HZ)?;
            self.attention = true;
        }
        Ok(())
    }

    fn nvic(&mut self) -> &mut Nvic {
        &mut self.system.nvic
    }

    fn faults(&mut self) -> &mut FaultStatus {
        &mut self.system.faults
    }

    fn mpu(&self) -> &Mpu {
        &self.system.mpu
    }

    fn vector_table(&self) -> u32 {
        self.system.vector_table()
    }

    fn now(&self) -> u64 {
        self.now
    }

    fn spend(&mut self, core_cycles: u32) {
        self.now += u64::from(core_cycles);
    }

    fn pass(&mut self, until: u64, _: bool) {
        self.now = until;
    }

    fn settle(&mut self) {
        if self.ticks && self.system.systick.settle(self.now, CORE_HZ) {
            self.system.nvic.pend(SYSTICK);
        }
    }

    fn next_event(&self) -> u64 {
        if self.ticks { self.system.systick.next_event(CORE_HZ) } else { u64::MAX }
    }

    fn needs_attention(&self) -> bool {
        self.attention
    }

    fn attended(&mut self) {
        self.attention = false;
    }

    fn stalled_until(&self) -> Option<u64> {
        None
    }

    fn wants_reset(&self) -> bool {
        self.system.reset_requested
    }

    fn wants_pause(&self) -> bool {
        false
    }

    fn memory_jobs(&mut self) -> Vec<MemoryJob> {
        Vec::new()
    }

    fn fetched(&mut self, _: &[u8]) {}
}

/// Result of a run.
#[derive(Debug, PartialEq, Eq)]
pub struct ImageRun {
    steps: Vec<ExceptionStep>,
    /// Bytes that it has written to the host.
    pub bytes: Vec<u8>,
}

/// Files by semihosting, and the command line.
struct SemihostingHost<'a> {
    words: &'a str,
    files: BTreeMap<String, Vec<u8>>,
    /// Names and places of those that are open; the handle is the index and one.
    open: Vec<(String, usize)>,
}

impl SemihostingHost<'_> {
    /// Carries out a call; none if it is the end.
    fn call(&mut self, core: &mut Processor<BareBoard>, operation: u32, block: u32) -> Option<u32> {
        let mut words = [[0; 4]; 4];
        // A plain exit has a reason in place of a block.
        core.read_memory(block, words.as_flattened_mut()).unwrap_or_default();
        let [first, second, third, _] = words.map(u32::from_le_bytes);
        Some(match operation {
            // OPEN: name, mode, length.
            0x01 => {
                let mut name = vec![0; third as usize];
                core.read_memory(first, &mut name).unwrap();
                let name = String::from_utf8(name).unwrap();
                let is_written = second >= 4;
                if !is_written && !self.files.contains_key(&name) {
                    return Some(u32::MAX);
                }
                self.files.entry(name.clone()).or_default();
                self.open.push((name, 0));
                self.open.len() as u32
            }
            // WRITE: handle, bytes, length.
            0x05 => {
                let (name, at) = &mut self.open[first as usize - 1];
                let file = self.files.get_mut(name).unwrap();
                let end = *at + third as usize;
                file.resize(file.len().max(end), 0);
                core.read_memory(second, &mut file[*at..end]).unwrap();
                *at = end;
                0
            }
            // READ: the same; gives what is missing.
            0x06 => {
                let (name, at) = &mut self.open[first as usize - 1];
                let file = &self.files[name];
                let length = (third as usize).min(file.len() - *at);
                core.write_memory(second, &file[*at..*at + length]).unwrap();
                *at += length;
                third - length as u32
            }
            // SEEK: handle, place.
            0x0a => {
                self.open[first as usize - 1].1 = second as usize;
                0
            }
            // GET_CMDLINE: where it goes.
            0x15 => {
                core.write_memory(first, format!("{}\0", self.words).as_bytes()).unwrap();
                0
            }
            // EXIT and EXIT_EXTENDED.
            0x18 | 0x20 => return None,
            other => panic!("semihosting call {other:#x}"),
        })
    }
}

/// Runs an image here, until it ends or starts anew.
pub fn here(image: &Path, words: &str, input: &[u8], ticks: bool) -> ImageRun {
    let (_, flash) = FlashImage::read_flash(image).unwrap();
    let mut bus = BareBoard { ticks, ..BareBoard::default() };
    bus.nvic().trace = Some(Vec::new());
    let mut core = Processor::new(bus, &flash).unwrap();
    core.halt_at_breakpoints();
    core.start().unwrap();
    let files = BTreeMap::from([(TO_BOARD.to_owned(), input.to_vec())]);
    let mut host = SemihostingHost { words, files, open: Vec::new() };
    while core.run(GIVEN_UP).unwrap() == Pause::Breakpoint {
        let (place, [operation, block]) = core.arguments().unwrap();
        let Some(result) = host.call(&mut core, operation, block) else { break };
        core.jump(place + 2, result).unwrap();
    }
    assert!(core.bus().now() < GIVEN_UP, "it does not end");
    let bytes = host.files.remove(FROM_BOARD).unwrap_or_default();
    ImageRun { steps: core.bus_mut().nvic().trace.take().unwrap(), bytes }
}

/// The same by QEMU, which tells of every exception.
pub fn by_qemu(image: &Path, words: &str, input: &[u8]) -> ImageRun {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(TO_BOARD), input).unwrap();
    let handed: String = words.split(' ').map(|word| format!(",arg={word}")).collect();
    let status = Command::new(std::env::var("ANEMO_QEMU").unwrap_or_else(|_| "qemu-system-arm".to_owned()))
        .args(["-M", "netduinoplus2", "-display", "none", "-monitor", "none", "-serial", "null", "-no-reboot"])
        .args(["-icount", "shift=0,sleep=off", "-d", "int", "-D", "exceptions.txt"])
        .args(["-semihosting-config", &format!("enable=on,target=native{handed}"), "-kernel"])
        .arg(image.canonicalize().unwrap())
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .status();
    status.unwrap();
    let number = |line: &str, before: &str| line.split_once(before)?.1.trim().parse().ok();
    let step = |line: &str| {
        let entered = number(line, "...taking pending nonsecure exception ").map(ExceptionStep::Enter);
        entered.or_else(|| number(line, " previous exception ").map(ExceptionStep::Leave))
    };
    let log = std::fs::read_to_string(folder.path().join("exceptions.txt")).unwrap();
    let bytes = std::fs::read(folder.path().join(FROM_BOARD)).unwrap_or_default();
    ImageRun { steps: log.lines().filter_map(step).collect(), bytes }
}

pub fn image(name: &str) -> PathBuf {
    let path = rig::image().with_file_name(format!("{name}-virtual-board.elf"));
    assert!(path.exists(), "no image at {}: `cargo xtask test` builds it and then runs these tests", path.display());
    path
}

/// A run of an experiment in frames: set-up, ticks with readings, ticks of silence until the
/// dead-man timer expires, a setting that is stored, and a fault at the end.
fn conversation() -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/gusts.toml");
    let experiment = Experiment::read(&path).unwrap();
    let (mut controller, mut sensor) = (InProcess::new(), experiment.sensor().unwrap());
    let setup = setup_of(&experiment).unwrap();
    let commands: Vec<_> = [BoardCommand::Clear].into_iter().chain(setup).chain([ARM, BoardCommand::Start]).collect();
    let mut messages = vec![ToBoard::Hello, ToBoard::Telemetry { every: 1 }];
    for command in commands {
        controller.command(command).unwrap();
        messages.push(ToBoard::Command(command));
    }
    for _ in 0..40 {
        let readings: Vec<Reading> = sensor.codes().iter().map(|&code| Reading::Code(code)).collect();
        let report = controller.exchange(&readings).unwrap();
        sensor.advance(report.sample.heaters.0);
        messages.push(ToBoard::Readings(Readings::new(&readings).unwrap()));
    }
    messages.extend([ToBoard::Silence, ToBoard::Silence, ToBoard::Silence]);
    messages.push(ToBoard::Command(BoardCommand::Acknowledge));
    let requests = host_sim::settings::write_requests(&crate::settings::every(3)).unwrap();
    messages.extend(requests.into_iter().map(ToBoard::Settings));
    messages.push(ToBoard::Provoke(Provocation::Fault));
    let frames =
        (1..).zip(&messages).map(|(number, message)| encode(number, message, &mut [0; MAX_FRAME]).unwrap().to_vec());
    frames.flatten().collect()
}

#[test]
fn the_virtual_board_takes_the_same_exceptions_and_says_the_same_as_in_qemu() {
    let (image, input) = (image("firmware"), conversation());
    let (here, there) = (here(&image, "firmware", &input, false), by_qemu(&image, "firmware", &input));
    assert!(
        here.steps.len() > 200 && here.bytes.len() > 3_000,
        "{} steps, {} bytes",
        here.steps.len(),
        here.bytes.len()
    );
    assert!(here.steps.contains(&ExceptionStep::Enter(3)), "it ends with a hard fault");
    let differs = here.steps.iter().zip(&there.steps).position(|(a, b)| a != b);
    assert_eq!(differs, None);
    assert!(here == there);
}

#[test]
fn a_stack_that_runs_over_takes_the_same_exceptions_as_in_qemu() {
    for way in ["overflow call", "overflow interrupt"] {
        let image = image("overflow");
        let outcome = here(&image, way, &[], false);
        assert_eq!(outcome.steps.last(), Some(&ExceptionStep::Enter(3)), "{way}");
        assert_eq!(outcome, by_qemu(&image, way, &[]), "{way}");
    }
}
