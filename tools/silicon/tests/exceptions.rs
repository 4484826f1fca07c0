//! Exceptions on a program of a few instructions: what an interrupted program finds afterwards, in
//! its registers, its floating-point registers and its stack, with one handler inside another.

use silicon::processor::Processor;
use silicon::processor::bus::{BusFault, MemoryJob, ProcessorBus};
use silicon::processor::fault::FaultStatus;
use silicon::processor::mpu::Mpu;
use silicon::processor::nvic::{FIRST_INTERRUPT, Nvic};

const FLASH: usize = 0x0800_0000;
const CODE: usize = 0x0801_0000;
/// Not a multiple of eight, so that an entry has to align it.
const STACK: u32 = 0x2000_fffc;
const PORT: u32 = 0x4000_0000;

/// `movs r4, #0x40; lsls r4, r4, #24; movs r0, #0x11; vmov s0, #1.0; vmov s15, #2.0;` then for ever
/// `wfi`, and s0, r0, s15, sp to PORT + 16, 20, 24, 28.
const MAIN: &[u16] = &[
    0x2440, 0x0624, 0x2011, 0xeeb7, 0x0a00, 0xeef0, 0x7a00, 0xbf30, 0xee10, 0x3a10, 0x6123, 0x6160, 0xee17, 0x3a90,
    0x61a3, 0x466b, 0x61e3, 0xe7f4,
];
/// `movs r0, #0x33; movs r1, #0; vmov s0, #3.0; vmov s15, #3.0; movs r2, #0x40; lsls r2, r2, #24;
/// str r0, [r2]`, which has interrupt 1 wait; a branch to the next instruction; r0 to PORT + 8, s0
/// to PORT + 12; `bx lr`.
const OUTER: &[u16] = &[
    0x2033, 0x2100, 0xeeb0, 0x0a08, 0xeef0, 0x7a08, 0x2240, 0x0612, 0x6010, 0xe7ff, 0x6090, 0xee10, 0x3a10, 0x60d3,
    0x4770,
];
/// `movs r0, #0x77; vmov s0, #4.0; movs r2, #0x40; lsls r2, r2, #24; str r0, [r2, #4]; bx lr`.
const INNER: &[u16] = &[0x2077, 0xeeb1, 0x0a00, 0x2240, 0x0612, 0x6050, 0x4770];

/// Loads from the address at PROBE + 12; a branch to the next instruction, since a fault is taken
/// between blocks; what was found to PORT + 16; then stays there.
const LOADS: &[u16] = &[0x4902, 0x4c03, 0x6808, 0xe7ff, 0x6120, 0xe7fe];
const PROBE: usize = 0x300;
/// The hard fault: 0x55 to PORT + 4, then stays there.
const FAULT: &[u16] = &[0x2055, 0x2240, 0x0612, 0x6050, 0xe7fe];

/// Two interrupts, and a port whose stores are written down.
struct Notebook {
    now: u64,
    nvic: Nvic,
    faults: FaultStatus,
    mpu: Mpu,
    interrupt_at: u64,
    attention: bool,
    stores: Vec<(u32, u32)>,
}

impl ProcessorBus for Notebook {
    fn load(&mut self, address: u32, _: usize) -> Result<u32, BusFault> {
        Err(BusFault(address))
    }

    fn store(&mut self, address: u32, _: usize, value: u32) -> Result<(), BusFault> {
        self.stores.push((address - PORT, value));
        if address == PORT {
            self.nvic.pend(FIRST_INTERRUPT + 1);
            self.attention = true;
        }
        Ok(())
    }

    fn nvic(&mut self) -> &mut Nvic {
        &mut self.nvic
    }

    fn faults(&mut self) -> &mut FaultStatus {
        &mut self.faults
    }

    fn mpu(&self) -> &Mpu {
        &self.mpu
    }

    fn vector_table(&self) -> u32 {
        FLASH as u32
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
        if self.now >= self.interrupt_at {
            self.interrupt_at = u64::MAX;
            self.nvic.pend(FIRST_INTERRUPT);
        }
    }

    fn next_event(&self) -> u64 {
        self.interrupt_at
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
        false
    }

    fn wants_pause(&self) -> bool {
        false
    }

    fn memory_jobs(&mut self) -> Vec<MemoryJob> {
        Vec::new()
    }

    fn fetched(&mut self, _: &[u8]) {}
}

fn flash() -> Vec<u8> {
    let mut flash = vec![0xff; 1024 * 1024];
    let mut put = |at: usize, bytes: &[u8]| flash[at - FLASH..at - FLASH + bytes.len()].copy_from_slice(bytes);
    let vectors = [
        (0, STACK),
        (1, CODE as u32 | 1),
        (3, CODE as u32 + 0x401),
        (16, CODE as u32 + 0x101),
        (17, CODE as u32 + 0x201),
    ];
    for (vector, value) in vectors {
        put(FLASH + 4 * vector, &value.to_le_bytes());
    }
    for (place, code) in [(0, MAIN), (0x100, OUTER), (0x200, INNER), (PROBE, LOADS), (0x400, FAULT)] {
        put(CODE + place, &code.iter().flat_map(|half| half.to_le_bytes()).collect::<Vec<_>>());
    }
    flash
}

/// Runs the program with priorities of the outer and the inner interrupt.
fn run(outer: u8, inner: u8) -> Vec<(u32, u32)> {
    let mut nvic = Nvic::default();
    nvic.write_enable(0, 0b11, true);
    nvic.set_priority_byte(FIRST_INTERRUPT, outer);
    nvic.set_priority_byte(FIRST_INTERRUPT + 1, inner);
    let bus = Notebook {
        now: 0,
        faults: FaultStatus::default(),
        mpu: Mpu::default(),
        nvic,
        interrupt_at: 1_000,
        attention: false,
        stores: Vec::new(),
    };
    let mut core = Processor::new(bus, &flash()).unwrap();
    core.start().unwrap();
    core.run(5_000).unwrap();
    core.bus().stores.clone()
}

const ONE: u32 = 1.0_f32.to_bits();
const TWO: u32 = 2.0_f32.to_bits();
const THREE: u32 = 3.0_f32.to_bits();

#[test]
fn a_handler_inside_another_leaves_all_registers_as_they_were() {
    let expected = [(0, 0x33), (4, 0x77), (8, 0x33), (12, THREE), (16, ONE), (20, 0x11), (24, TWO), (28, STACK)];
    assert_eq!(run(0x50, 0x30), expected);
}

#[test]
fn a_handler_of_equal_priority_comes_after_the_first() {
    // And before the program, which sees one interruption.
    let stores = run(0x50, 0x50);
    assert_eq!(stores[..4], [(0, 0x33), (8, 0x33), (12, THREE), (4, 0x77)]);
    assert_eq!(stores[4..8], [(16, ONE), (20, 0x11), (24, TWO), (28, STACK)]);
}

/// Regions as base and attributes; what a load from the address comes to.
fn load_from(address: u32, regions: &[(u32, u32)]) -> Vec<(u32, u32)> {
    let mut flash = flash();
    let literals = [address, PORT].map(u32::to_le_bytes);
    flash[CODE - FLASH + PROBE + 12..][..8].copy_from_slice(literals.as_flattened());
    flash[4..8].copy_from_slice(&(CODE as u32 + PROBE as u32 + 1).to_le_bytes());
    let mut mpu = Mpu::default();
    for (number, &(base, attributes)) in (0..).zip(regions) {
        mpu.store(0x08, number);
        mpu.store(0x0c, base);
        mpu.store(0x10, attributes | 1);
    }
    mpu.store(0x04, u32::from(!regions.is_empty()));
    let (nvic, stores) = (Nvic::default(), Vec::new());
    let bus = Notebook {
        now: 0,
        faults: FaultStatus::default(),
        mpu,
        nvic,
        interrupt_at: u64::MAX,
        attention: false,
        stores,
    };
    let mut core = Processor::new(bus, &flash).unwrap();
    core.start().unwrap();
    core.run(1_000).unwrap();
    core.bus().stores.clone()
}

#[test]
fn all_that_is_mapped_is_read_by_right_only() {
    const SYSTEM_MEMORY: u32 = 0x1fff_7a10;
    // 1 MiB of flash, 512 MiB of peripherals, 1 KiB of RAM with the stack and no other.
    let mut regions = vec![(0x0800_0000, 6 << 24 | 19 << 1), (PORT, 3 << 24 | 28 << 1)];
    regions.push((0x2000_fc00, 3 << 24 | 9 << 1));
    let anemo = u32::from_le_bytes(*b"anem");
    assert_eq!(load_from(SYSTEM_MEMORY, &[]), [(16, anemo)]);
    for address in [SYSTEM_MEMORY, 0x1fff_7000, 0x2000_0000, 0x2000_fbfc, 0x2001_0000] {
        assert_eq!(load_from(address, &regions), [(4, 0x55)], "{address:#x}");
    }
    for address in [0x2000_fc00, CODE as u32 + 0x408] {
        assert_eq!(load_from(address, &regions)[0].0, 16, "{address:#x}");
    }
    // 512 bytes of the system memory.
    regions.push((0x1fff_7a00, 6 << 24 | 8 << 1));
    assert_eq!(load_from(SYSTEM_MEMORY, &regions), [(16, anemo)]);
    for address in [0x1fff_79fc, 0x1fff_7c00] {
        assert_eq!(load_from(address, &regions), [(4, 0x55)], "{address:#x}");
    }
}
