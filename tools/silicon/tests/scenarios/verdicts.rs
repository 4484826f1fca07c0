//! Verdicts of two cores, QEMU's and ours, on the firmware's own protection, on faults, priorities
//! and SysTick (`firmware/src/bin/verdicts.rs`). Both have to give the one that is expected.
//!
//! Where one of them is not the chip's, [`QEMU_DIFFERS`] and [`WE_DIFFER`] say so.

use crate::against_qemu::{by_qemu, here, image};

/// Rights that the protection gives the sensor board there: load, store, jump. `x` is a jump that
/// is allowed and not tried; `?` is allowed, and nothing answers.
const RIGHTS: [(u32, &str); 44] = [
    // The image has no business with the alias of flash that the core starts from.
    (0x0000_0000, "---"),
    (0x0000_0400, "---"),
    (0x07ff_fffc, "---"),
    // Vectors; settings; code.
    (0x0800_0000, "r-x"),
    (0x0800_3ffc, "r-x"),
    (0x0800_4000, "rw-"),
    (0x0800_7ffc, "rw-"),
    (0x0800_8000, "rw-"),
    (0x0800_fffc, "rw-"),
    (0x0801_0000, "r-x"),
    (0x080f_fffc, "r-x"),
    (0x0810_0000, "---"),
    // Memory of the core alone.
    (0x1000_0000, "---"),
    (0x1000_fffc, "---"),
    // ST's own: the number of the processor, option bytes.
    (0x1fff_7000, "---"),
    (0x1fff_79fc, "---"),
    (0x1fff_7a00, "r--"),
    (0x1fff_7a10, "r--"),
    (0x1fff_7a14, "r--"),
    (0x1fff_7a18, "r--"),
    (0x1fff_7bfc, "r--"),
    (0x1fff_7c00, "---"),
    (0x1fff_c000, "---"),
    (0x1fff_fffc, "---"),
    // RAM, what comes after it, its alias by bits.
    (0x2000_0000, "rw-"),
    (0x2001_fffc, "rw-"),
    (0x2002_0000, "---"),
    (0x2002_fffc, "---"),
    (0x2200_0000, "---"),
    (0x3fff_fffc, "---"),
    // Peripherals, and their alias.
    (0x4000_0000, "rw-"),
    (0x4000_4408, "rw-"),
    (0x4001_3000, "rw-"),
    (0x4002_3800, "rw-"),
    (0x4200_0000, "rw-"),
    (0x5fff_fffc, "??-"),
    (0x6000_0000, "---"),
    (0x8000_0000, "---"),
    (0xa000_0000, "---"),
    (0xdfff_fffc, "---"),
    // The core's own registers are open to whoever is privileged, whatever the protection says.
    (0xe000_ed08, "rw-"),
    (0xe000_ed94, "rw-"),
    (0xe010_0000, "---"),
    // A jump there is a return from an exception.
    (0xffff_fffc, "--x"),
];

const DACCVIOL: u32 = 0x82;
const IACCVIOL: u32 = 1;
const PRECISERR: u32 = 0x8200;
const IMPRECISERR: u32 = 0x400;
const UNDEFINSTR: u32 = 1 << 16;
const INVSTATE: u32 = 1 << 17;
const NOCP: u32 = 1 << 19;
const UNALIGNED: u32 = 1 << 24;
const FORCED: u32 = 1 << 30;

/// Outcomes of the image's instructions, in its order: an undefined one, a coprocessor's, a pair
/// and a word that are not aligned, a division by zero. The last two are faults only where CCR asks
/// for it, which the firmware does not.
const INSTRUCTIONS: [u32; 5] = [UNDEFINSTR, NOCP, UNALIGNED, 0, 0];

/// Registers of the core: what is written to them, and which bits they keep of it (DDI 0403E,
/// B3.2.5, B3.3.4, B3.4.9, B3.2.6, B3.2.20, B3.2.10).
const KEPT: [(u32, u32, u32); 7] = [
    // VTOR: a table of 98 vectors is aligned to 512 bytes.
    (0xe000_ed08, 0x0800_0200, 0x0800_0200),
    // SysTick's reload value.
    (0xe000_e014, u32::MAX, 0x00ff_ffff),
    // Priorities of interrupts 8 to 11.
    (0xe000_e408, u32::MAX, 0xf0f0_f0f0),
    // AIRCR: without its key nothing is written.
    (0xe000_ed0c, 0, 0xfa05_0000),
    // CPACR: the floating-point unit is the only coprocessor.
    (0xe000_ed88, u32::MAX, 0x00f0_0000),
    // Priorities of MemManage, BusFault and UsageFault; of PendSV and SysTick.
    (0xe000_ed18, u32::MAX, 0x00f0_f0f0),
    (0xe000_ed20, 0xffff_0000, 0xf0f0_0000),
];

/// Where QEMU's verdict is not the chip's, and why.
const QEMU_DIFFERS: [(Trials, &str); 3] = [
    (
        |trial| matches!(trial, Trial::Load(0x1fff_7a00..=0x1fff_7bfc)),
        "it has no system memory (RM0090, table 5), so what the protection lets through finds nobody: PRECISERR",
    ),
    (
        |trial| matches!(trial, Trial::Store(0x5fff_fffc)),
        "it has no write buffer; a store's bus fault may be imprecise (DDI 0403E, B1.5.14, \"BusFault\")",
    ),
    (
        |trial| matches!(trial, Trial::Keep(0xe000_e408 | 0xe000_ed18..=0xe000_ed20, _)),
        "this version keeps eight bits of a priority; the chip keeps four (PM0214, 4.3.7)",
    ),
];

/// Where ours is not the chip's, and why.
const WE_DIFFER: [(Trials, &str); 1] = [(
    |trial| matches!(trial, Trial::Instruction(2)),
    "Unicorn 2.1 loads a pair from an odd half-word as if it were allowed (DDI 0403E, A3.2.1)",
)];

/// Where our fault comes later than the chip's: registers, and memory that is answered like them,
/// are asked in the middle of a block of instructions, and the core stops at its end.
const LATE: Trials = |trial| matches!(trial, Trial::Load(address) | Trial::Store(address) if address >> 12 == 0x1fff7);

type Trials = fn(Trial) -> bool;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trial {
    Load(u32),
    Store(u32),
    Jump(u32),
    /// To RAM, in the handler of a fault.
    JumpInFault,
    /// A value that a register is to keep.
    Keep(u32, u32),
    /// One interrupt inside another: priorities of RTIC, and the ceiling of the outer one's lock.
    Priorities {
        outer: u8,
        inner: u8,
        ceiling: u8,
    },
    Tick,
    Protect,
    Instruction(u32),
}

impl Trial {
    /// Words as the image reads them.
    fn words(self) -> [u32; 3] {
        match self {
            Self::Load(address) => [0, address, 0],
            Self::Store(address) => [1, address, 0],
            Self::Jump(address) => [2, address, 0],
            Self::JumpInFault => [3, 0, 0],
            Self::Keep(address, value) => [4, address, value],
            Self::Priorities { outer, inner, ceiling } => [5, u32::from_le_bytes([outer, inner, ceiling, 0]), 0],
            Self::Tick => [6, 0, 0],
            Self::Protect => [7, 0, 0],
            Self::Instruction(index) => [8, index, 0],
        }
    }
}

/// Verdict of a core on a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Verdict {
    values: [u32; 2],
    /// CFSR, HFSR, MMFAR and BFAR.
    fault: [u32; 4],
    /// Where it came.
    place: u32,
}

impl Verdict {
    fn fault(status: u32, address: u32) -> [u32; 4] {
        match status {
            0 => [0; 4],
            DACCVIOL => [status, FORCED, address, 0],
            PRECISERR => [status, FORCED, 0, address],
            _ => [status, FORCED, 0, 0],
        }
    }
}

/// Verdicts of our core and of QEMU's.
fn verdicts(trials: &[Trial]) -> [Vec<Verdict>; 2] {
    let image = image("verdicts");
    let input: Vec<u8> = trials.iter().flat_map(|trial| trial.words()).flat_map(u32::to_le_bytes).collect();
    [here(&image, "verdicts", &input, true), by_qemu(&image, "verdicts", &input)].map(|run| {
        let words: Vec<u32> = run.bytes.as_chunks().0.iter().copied().map(u32::from_le_bytes).collect();
        let verdict = |&[one, two, cfsr, hfsr, mmfar, bfar, place]: &[u32; 7]| Verdict {
            values: [one, two],
            fault: [cfsr, hfsr, mmfar, bfar],
            place,
        };
        let verdicts: Vec<_> = words.as_chunks().0.iter().map(verdict).collect();
        assert_eq!(verdicts.len(), trials.len(), "{:?} ends it", trials.get(verdicts.len()));
        verdicts
    })
}

/// Tries all, and holds both verdicts against what is expected of the chip.
fn judge(trials: &[(Trial, [u32; 4])], value: impl Fn(Trial) -> Option<u32>) {
    let all: Vec<Trial> = [Trial::Protect].into_iter().chain(trials.iter().map(|of| of.0)).collect();
    let [here, there] = verdicts(&all).map(|verdicts| verdicts[1..].to_vec());
    let mut wrong = Vec::new();
    for (i, &(trial, fault)) in trials.iter().enumerate() {
        let expected = |of: Verdict| of.fault == fault && value(trial).is_none_or(|value| of.values[0] == value);
        let mut check = |core: &str, of: Verdict, differs: &[(Trials, &str)]| {
            if expected(of) == differs.iter().any(|(which, _)| which(trial)) {
                wrong.push(format!("{core}: {trial:x?} is {of:x?}, not {fault:x?} {:x?}", value(trial)));
            }
        };
        check("ours", here[i], &WE_DIFFER);
        check("QEMU", there[i], &QEMU_DIFFERS);
        if here[i].fault == there[i].fault && (here[i].place == there[i].place) == LATE(trial) {
            wrong.push(format!("{trial:x?} comes at {:#x} here, at {:#x} in QEMU", here[i].place, there[i].place));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_protection_gives_the_rights_that_the_image_needs_and_no_others() {
    let mut trials = Vec::new();
    for (address, rights) in RIGHTS {
        let (load, store, jump) = (&rights[..1], &rights[1..2], &rights[2..]);
        let status = |right, refused, missing| match right {
            "-" => refused,
            "?" => missing,
            _ => 0,
        };
        let of = |trial, status| (trial, Verdict::fault(status, address));
        trials.push(of(Trial::Load(address), status(load, DACCVIOL, PRECISERR)));
        trials.push(of(Trial::Store(address), status(store, DACCVIOL, IMPRECISERR)));
        if jump == "-" {
            trials.push(of(Trial::Jump(address | 1), IACCVIOL));
        }
    }
    judge(&trials, |_| None);
}

#[test]
fn faults_escalate_with_their_reason() {
    let instructions = (0..).zip(INSTRUCTIONS).map(|(index, status)| (Trial::Instruction(index), status));
    // Arm's other instructions, which an even address asks for; and RAM, where only a fault's handler may execute.
    let jumps = [(Trial::Jump(0x0801_0000), INVSTATE), (Trial::JumpInFault, UNDEFINSTR)];
    let trials: Vec<_> = instructions.chain(jumps).map(|(trial, status)| (trial, Verdict::fault(status, 0))).collect();
    judge(&trials, |_| None);
}

#[test]
fn registers_keep_the_bits_that_they_have() {
    let trials: Vec<_> = KEPT.iter().map(|&(register, value, _)| (Trial::Keep(register, value), [0; 4])).collect();
    let kept = |trial| KEPT.iter().find(|of| Trial::Keep(of.0, of.1) == trial).map(|of| of.2);
    judge(&trials, kept);
}

#[test]
fn priorities_locks_and_floats_are_as_rtic_has_them() {
    let mut trials = Vec::new();
    for (outer, inner) in (1..=6).flat_map(|outer| (1..=6).map(move |inner| (outer, inner))) {
        let ceilings = [0].into_iter().chain(outer..=6);
        trials.extend(ceilings.map(|ceiling| Trial::Priorities { outer, inner, ceiling }));
    }
    let [here, there] = verdicts(&trials);
    for ((&trial, here), there) in trials.iter().zip(here).zip(there) {
        let Trial::Priorities { outer, inner, ceiling } = trial else { continue };
        // 1 outer, 2 in its lock, 3 after it; 4 inner.
        let order = match inner {
            _ if inner > outer.max(ceiling) => 0x1423,
            _ if inner > outer => 0x1243,
            _ => 0x1234,
        };
        assert_eq!(here.values[0], order, "{trial:?}");
        // Sums of all floats, too.
        assert_eq!(here, there, "{trial:?}");
    }
}

#[test]
fn systick_counts_waits_and_comes_as_the_health_task_starts_it() {
    // CSR and PENDSTSET before the first beat, after it with interrupts off, and after its exception.
    let expected = [0x70_7160, 168_000_000 / 20 - 1];
    assert_eq!(verdicts(&[Trial::Tick]).map(|verdicts| verdicts[0].values), [expected; 2]);
}
