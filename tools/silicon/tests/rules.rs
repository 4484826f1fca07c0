//! Every rule is broken once, register by register, and complained about; what keeps to all of them
//! is not.

use host_sim::sensor::SensorConfig;
use silicon::board::Board;
use silicon::complaint::BrokenRule;
use silicon::plant::SensorPlant;
use silicon::processor::bus::ProcessorBus;
use silicon::time::{ms, us};

const RCC: u32 = 0x4002_3800;
const FLASH: u32 = 0x4002_3c00;
const PORT_A: u32 = 0x4002_0000;
const PORT_B: u32 = 0x4002_0400;
const SPI1: u32 = 0x4001_3000;
const USART2: u32 = 0x4000_4400;
const DMA1: u32 = 0x4002_6000;
const POWER: u32 = 0x4000_7000;
const WATCHDOG: u32 = 0x4000_3000;
const SETTINGS: u32 = 0x0800_4000;

/// PLL from the crystal: 8/4·168/2 MHz.
const PLL: u32 = 1 << 22 | 168 << 6 | 4;
/// AHB undivided, APB1 a quarter, APB2 a half; the PLL for the core.
const BUSES: u32 = 0b101 << 10 | 0b100 << 13 | 2;
/// SCK, PA5, high; the debug pin as after a reset.
const SPEEDS: u32 = 0x0c00_0000 | 2 << 10;
/// SPI1 on, master, mode 1, an eighth of 84 MHz, chip select by software.
const SPI_ON: u32 = 1 << 9 | 1 << 8 | 1 << 6 | 2 << 3 | 1 << 2 | 1;

/// A board whose registers are written by hand.
struct Bench(Board);

impl Bench {
    fn new() -> Self {
        Self(Board::new(SensorPlant::new(&SensorConfig::default()).unwrap(), 32_000))
    }

    /// At 168 MHz, with all clocks that the board uses, and its pins where they belong.
    fn running() -> Self {
        let mut bench = Self::new();
        bench.store(RCC, 1 << 16 | 0x83).wait(ms(3));
        bench.store(RCC + 0x04, PLL).store(RCC, 1 << 24 | 1 << 16 | 0x83).wait(ms(1));
        bench.store(FLASH, 5).store(RCC + 0x08, BUSES);
        bench
            .store(RCC + 0x30, 1 << 21 | 0b111)
            .store(RCC + 0x40, 1 << 17 | 1 << 3)
            .store(RCC + 0x44, 1 << 12 | 1 << 14);
        bench.0.barrier();
        // PA2, PA3: function 7. PA4: output, high. PA5 to PA7: function 5.
        bench.store(PORT_A + 0x18, 1 << 4).store(PORT_A + 0x20, 0x5550_7700).store(PORT_A, 0xa800_a9a0);
        bench.store(PORT_A + 0x08, SPEEDS);
        // PB0: output, high.
        bench.store(PORT_B + 0x18, 1).store(PORT_B, 0x281);
        bench
    }

    /// The same with the converter on its bus, out of its reset, and not streaming.
    fn converting() -> Self {
        let mut bench = Self::running();
        bench.store(SPI1, SPI_ON).wait(ms(130));
        bench.store(PORT_B + 0x18, 1 << 16).wait(us(10)).store(PORT_B + 0x18, 1).wait(us(20));
        bench.command(&[0x11]);
        bench
    }

    fn store(&mut self, address: u32, value: u32) -> &mut Self {
        self.0.store(address, 4, value).ok();
        self
    }

    fn load(&mut self, address: u32) -> u32 {
        self.0.load(address, 4).unwrap_or(0)
    }

    fn wait(&mut self, cycles: u64) -> &mut Self {
        let until = self.0.now() + cycles;
        self.0.pass(until, false);
        self.0.settle();
        self
    }

    fn select(&mut self, low: bool) -> &mut Self {
        self.store(PORT_A + 0x18, if low { 1 << 20 } else { 1 << 4 })
    }

    fn byte(&mut self, byte: u8) -> u8 {
        self.store(SPI1 + 0x0c, byte.into()).wait(us(1));
        self.load(SPI1 + 0x0c) as u8
    }

    /// Bytes of a command, each with its time to be decoded.
    fn command(&mut self, bytes: &[u8]) -> &mut Self {
        self.select(true);
        for &byte in bytes {
            self.byte(byte);
            self.wait(us(2));
        }
        self.select(false).wait(us(1))
    }

    #[track_caller]
    fn complains(&self, rule: BrokenRule) {
        let all = self.0.complaints.all();
        assert!(all.iter().any(|complaint| complaint.rule == rule), "{rule:?} is not among {all:#?}");
    }

    #[track_caller]
    fn is_content(&self) {
        assert_eq!(self.0.complaints.all(), []);
    }
}

#[test]
fn the_clock_tree_is_watched() {
    Bench::running().is_content();
    let mut bench = Bench::new();
    bench.store(PORT_A, 0).complains(BrokenRule::ClockOff);
    bench.store(0x5000_0000, 0).complains(BrokenRule::Unmodelled(0x5000_0000));
    // 4 MHz into the PLL.
    let mut bench = Bench::new();
    bench.store(RCC, 1 << 16 | 0x83).wait(ms(3)).store(RCC + 0x04, PLL - 2).store(RCC, 1 << 24 | 1 << 16 | 0x83);
    bench.complains(BrokenRule::PllRange);
    // Changed while it runs.
    bench.store(RCC + 0x04, PLL).complains(BrokenRule::PllChangedWhileOn);
    // Taken at once.
    bench.store(RCC + 0x08, BUSES).complains(BrokenRule::ClockNotReady);
    bench.complains(BrokenRule::WaitStates { needed: 5, set: 0 });
    // One prescaler off by one: APB1 at 84 MHz.
    let mut bench = Bench::running();
    bench.store(RCC + 0x08, 0b100 << 10 | 0b100 << 13 | 2).complains(BrokenRule::ClockTooFast);
    // Spoken to at once, as a store and a load behind one another are; not after a barrier.
    let mut bench = Bench::new();
    bench.store(RCC + 0x40, 1 << 28);
    assert_eq!(bench.load(POWER), 0);
    bench.complains(BrokenRule::ClockJustOn);
    let mut bench = Bench::new();
    bench.store(RCC + 0x40, 1 << 28);
    bench.0.barrier();
    assert_eq!(bench.load(POWER), 0x4000);
    bench.is_content();
    // The value that was read as zero is written back: scale 2, for 144 MHz at the most.
    let mut bench = Bench::running();
    bench.store(RCC + 0x40, 1 << 28).wait(us(1)).store(POWER, 7 << 5 | 1 << 4).complains(BrokenRule::VoltageScale);
    // A wait state too few.
    let mut bench = Bench::running();
    bench.store(FLASH, 4).complains(BrokenRule::WaitStates { needed: 5, set: 4 });
}

#[test]
fn the_flash_is_watched() {
    let unlock = |bench: &mut Bench| {
        bench.store(FLASH + 4, 0x4567_0123).store(FLASH + 4, 0xcdef_89ab);
    };
    let mut bench = Bench::running();
    unlock(&mut bench);
    // By words: PSIZE 2, PG.
    bench.store(FLASH + 0x10, 2 << 8 | 1).store(SETTINGS, 0x1234_5678).wait(us(20));
    assert_eq!(bench.load(SETTINGS), 0x1234_5678);
    bench.is_content();
    bench.store(SETTINGS, 0xffff_ffff).complains(BrokenRule::FlashNotErased);
    bench.wait(us(20)).store(FLASH + 0x10, 1).store(SETTINGS + 8, 0).complains(BrokenRule::FlashProgramming);
    // The cache is on during an erase, and is not reset: off, reset, on would be right.
    bench.store(FLASH, 1 << 10 | 5).wait(us(20)).store(FLASH + 0x10, 1 << 16 | 1 << 3 | 1 << 1).wait(ms(300));
    bench.load(SETTINGS);
    bench.complains(BrokenRule::StaleCache);
    bench.store(FLASH, 1 << 12 | 1 << 10 | 5).complains(BrokenRule::CacheResetWhileOn);

    let mut bench = Bench::running();
    bench.store(FLASH + 0x10, 1).complains(BrokenRule::FlashLocked);
    bench.store(FLASH + 4, 0xcdef_89ab).complains(BrokenRule::FlashKey);
}

#[test]
fn the_converters_bus_is_watched() {
    let mut bench = Bench::converting();
    // Its identity.
    bench.select(true);
    for byte in [0x20, 0x00] {
        bench.byte(byte);
        bench.wait(us(2));
    }
    assert_eq!(bench.byte(0), 0xd1);
    bench.wait(us(2)).select(false);
    bench.is_content();

    let broken = |act: &dyn Fn(&mut Bench), rule| {
        let mut bench = Bench::converting();
        act(&mut bench);
        bench.complains(rule);
    };
    // Mode 0: the phase is the other one.
    let mode_0 = |bench: &mut Bench| {
        bench.store(SPI1, SPI_ON & !1).command(&[0x11]);
    };
    broken(&mode_0, BrokenRule::SpiMode);
    // 42 MHz.
    let too_fast = |bench: &mut Bench| {
        bench.store(SPI1, SPI_ON & !(7 << 3)).command(&[0x11]);
    };
    broken(&too_fast, BrokenRule::AdcClock);
    broken(
        &|bench| {
            bench.store(SPI1, 0).store(SPI1 + 0x0c, 0);
        },
        BrokenRule::SpiWrite,
    );
    broken(
        &|bench| {
            bench.store(PORT_A + 0x20, 0).store(SPI1 + 0x0c, 0);
        },
        BrokenRule::SpiPins,
    );
    let slow_pin = |bench: &mut Bench| {
        bench.store(PORT_A + 0x08, SPEEDS ^ 3 << 10).command(&[0x11]);
    };
    broken(&slow_pin, BrokenRule::SpiClockPin);
    let unread = |bench: &mut Bench| {
        bench.store(SPI1 + 0x0c, 0).wait(us(1)).store(SPI1 + 0x0c, 0).wait(us(1)).load(SPI1 + 0x08);
    };
    broken(&unread, BrokenRule::SpiOverrun);
    let changed = |bench: &mut Bench| {
        bench.store(SPI1 + 0x0c, 0).store(SPI1, SPI_ON & !1);
    };
    broken(&changed, BrokenRule::SpiChangedWhileBusy);
    let inside = |bench: &mut Bench| {
        bench.select(true).store(SPI1 + 0x0c, 0).select(false);
    };
    broken(&inside, BrokenRule::SelectInsideByte);
}

#[test]
fn the_converters_times_and_commands_are_watched() {
    let broken = |act: &dyn Fn(&mut Bench), rule| {
        let mut bench = Bench::converting();
        act(&mut bench);
        bench.complains(rule);
    };
    // Two bytes of a command, one behind the other.
    let hurried = |bench: &mut Bench| {
        bench.select(true).byte(0x20);
        bench.byte(0);
    };
    broken(&hurried, BrokenRule::AdcDecodeTime);
    let at_once = |bench: &mut Bench| {
        bench.command(&[0x11]).select(true).wait(us(2)).select(false).select(true);
    };
    broken(&at_once, BrokenRule::AdcSelectTime);
    broken(
        &|bench| {
            bench.command(&[0x10]).command(&[0x20, 0]);
        },
        BrokenRule::AdcRegisterWhileStreaming,
    );
    broken(
        &|bench| {
            bench.command(&[0xff]);
        },
        BrokenRule::AdcCommand,
    );
    // Data before there are any.
    broken(
        &|bench| {
            bench.command(&[0x08]).command(&[0x12]);
        },
        BrokenRule::AdcNoData,
    );
    // Spoken to right after its reset.
    let soon = |bench: &mut Bench| {
        bench.store(PORT_B + 0x18, 1 << 16).wait(us(10)).store(PORT_B + 0x18, 1).command(&[0x11]);
    };
    broken(&soon, BrokenRule::AdcResetTime);
    // A frame while the reference is off.
    let without_reference = |bench: &mut Bench| {
        bench.command(&[0x08]).wait(ms(2)).select(true).byte(0x12);
        bench.wait(us(2)).byte(0);
    };
    broken(&without_reference, BrokenRule::AdcReference);
    // A frame is begun 10 µs before the next conversion: 250 µs apart at 4 kSPS.
    let across = |bench: &mut Bench| {
        bench.command(&[0x41, 0x00, 0x94]).command(&[0x43, 0x00, 0xe0]).wait(ms(200));
        bench.command(&[0x08]).command(&[0x10]).wait(ms(5));
        while !bench.0.adc.data_ready_low() {
            bench.wait(us(1));
        }
        let next = bench.0.adc.next_event();
        let now = bench.0.now();
        bench.wait(next - now - us(10)).select(true);
        for _ in 0..21 {
            bench.byte(0);
        }
    };
    broken(&across, BrokenRule::AdcFrameAcrossUpdate);
}

#[test]
fn the_line_and_its_dma_are_watched() {
    /// Stream 6: channel 4, to the peripheral, memory increments, enabled.
    const SEND: u32 = 4 << 25 | 1 << 10 | 1 << 6 | 1;
    const STREAM_6: u32 = DMA1 + 0x10 + 6 * 0x18;
    let open = || {
        let mut bench = Bench::running();
        bench.store(USART2 + 8, 46).store(USART2 + 0x14, 1 << 7).store(USART2 + 0x0c, 1 << 13 | 1 << 3 | 1 << 2);
        bench.store(STREAM_6 + 4, 3).store(STREAM_6 + 8, USART2 + 4).store(STREAM_6 + 12, 0x2000_0000);
        bench
    };
    let mut bench = open();
    bench.store(STREAM_6, SEND);
    bench.is_content();
    bench.store(STREAM_6 + 4, 5).complains(BrokenRule::DmaChangedWhileOn);
    // Another channel; another stream.
    open().store(STREAM_6, SEND ^ 1 << 25).complains(BrokenRule::DmaRequest);
    open().store(STREAM_6 + 0x18, SEND).complains(BrokenRule::DmaRequest);
    open().store(PORT_A + 0x20, 0).store(STREAM_6, SEND).complains(BrokenRule::UsartPins);
    // The frame before has gone, and its flag stands.
    let mut bench = open();
    bench.store(STREAM_6, SEND);
    bench.0.memory_jobs();
    bench.0.fetched(&[1, 2, 3]);
    bench.wait(us(40));
    bench.0.memory_jobs();
    bench.0.fetched(&[1, 2, 4]);
    bench.complains(BrokenRule::DmaMemoryChanged);
    bench.store(STREAM_6, SEND).complains(BrokenRule::DmaFlagsStand);
    // A byte of the host that nobody takes, at a baud rate of 840 000.
    let mut bench = open();
    bench.store(USART2 + 8, 50);
    bench.0.receive(&[0x55]);
    bench.wait(us(20));
    bench.complains(BrokenRule::UsartOverrun);
    bench.complains(BrokenRule::UsartBaud);
}

#[test]
fn the_watchdog_is_watched() {
    let mut bench = Bench::running();
    bench.store(WATCHDOG + 8, 499).complains(BrokenRule::WatchdogProtected);
    let mut bench = Bench::running();
    bench.store(WATCHDOG, 0xcccc).store(WATCHDOG, 0x5555).store(WATCHDOG + 4, 3).store(WATCHDOG + 8, 499);
    bench.is_content();
    bench.store(WATCHDOG + 8, 400).complains(BrokenRule::WatchdogUpdating);
    bench.store(WATCHDOG, 0xaaaa).complains(BrokenRule::WatchdogReloadedEarly);
    let mut bench = Bench::running();
    bench.store(WATCHDOG, 0xcccc).store(WATCHDOG, 0x5555).store(WATCHDOG + 4, 3).store(WATCHDOG + 8, 499);
    bench.wait(us(200)).store(WATCHDOG, 0xaaaa);
    bench.is_content();
    // (499 + 1)·32/32 kHz.
    assert_eq!(bench.0.watchdog.period(), ms(500));
}

#[test]
fn regions_of_the_memory_protection_are_watched() {
    const MPU: u32 = 0xe000_ed90;
    let mut bench = Bench::running();
    assert_eq!(bench.load(MPU), 0x800);
    // 128 KiB of RAM.
    bench.store(MPU + 0x0c, 0x2000_0000 | 1 << 4 | 2).store(MPU + 0x10, 3 << 24 | 16 << 1 | 1);
    bench.is_content();
    bench.store(MPU + 0x0c, 0x2000_8000 | 1 << 4 | 2).complains(BrokenRule::MpuRegion);
    let mut bench = Bench::running();
    bench.store(MPU + 0x10, 3 << 24 | 3 << 1 | 1).complains(BrokenRule::MpuRegion);
}
