//! Texas Instruments ADS131E06: six delta-sigma ADCs that sample together, 24 bit, on SPI mode 1.
//!
//! ```text
//! V = code · V_ref / (G · 2²³),   V_ref = 4 V (internal),   G = 1
//! ```
//!
//! Source: data sheet SBAS561 (ADS131E04/E06/E08), cross-read with the Linux driver `ti-ads131e08`
//! and its device-tree binding. Times below are for the 2.048 MHz clock of the board, t_CLK = 488
//! ns.
//!
//! Start-up ([`Ads131e06::initialise`]): reset, identity, configuration with all inputs shorted
//! inside the chip, every register read back, the offset of each channel measured by conversions
//! that data-ready has announced, inputs connected, all registers read back again, continuous
//! conversion. From then on every falling edge of data-ready requires one
//! [`Ads131e06::read_frame`], and [`Ads131e06::verify`] finds a register that has changed.
//!
//! The offset is measured here and not by the chip's OFFSETCAL, because a number that is seen can
//! be refused: 0.35 mV (typical) would be 0.2 K at the low current and 0.04 K at the high one, a
//! step at every change of level.
//!
//! Limits: one chip, no daisy chain. The time to decode a byte is kept by waiting, so commands work
//! at any SCLK up to the chip's 20 MHz; a frame is out before the next one at 4 kSPS from 0.7 MHz
//! on. START pin low, PWDN pin high.

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::{Operation, SpiDevice};

use super::tick_plan::DataRate;
pub use error::AdcError;
use register::IDENTITY;
pub use register::{CHANNELS, OFFSET_LIMIT, Register};

mod error;
mod register;
/// Largest code: the input is at or above +V_ref.
pub const CODE_MAX: i32 = (1 << 23) - 1;
/// Smallest code: the input is at or below −V_ref.
pub const CODE_MIN: i32 = -(1 << 23);
/// Scale at gain 1 with the internal 4 V reference, V a code.
pub const VOLT_PER_CODE: f32 = 4.0 / 8_388_608.0;

/// Status word and one code a channel, three bytes each.
const FRAME_BYTES: usize = 3 + 3 * CHANNELS;
/// The four bits every status word begins with.
const STATUS_MARK: u8 = 0b1100;

/// What [`Ads131e06::verify`] takes at 10.5 MHz, polled byte by byte.
pub const VERIFY_US: u32 = 50;

/// Four t_CLK (1.95 µs) that the chip needs to decode each byte of a command, and between the last
/// byte and chip select.
const DECODE_NS: u32 = 2_000;
/// Two t_CLK (0.98 µs) that chip select stays high between commands.
const DESELECTED_US: u32 = 1;
/// 2¹⁸ t_CLK (128 ms) from power-on to the first reset.
const POWER_ON_MS: u32 = 130;
/// Two t_CLK (0.98 µs) is the shortest reset pulse.
const RESET_LOW_US: u32 = 10;
/// 18 t_CLK (8.8 µs) from the end of the reset to the first command.
const RESET_HIGH_US: u32 = 20;
/// Start-up of the internal reference with its capacitors, 150 ms typical.
const REFERENCE_MS: u32 = 200;
/// Conversions the offset is the mean of: takes 7 µV of noise down to 0.6 µV.
const OFFSET_CONVERSIONS: i32 = 128;

/// How often data-ready is looked at while an offset is measured.
const LOOK_US: u32 = 5;
/// Conversion periods that one may take: the first after START takes 4.5.
const LONGEST_PERIODS: u32 = 8;

mod command {
    pub const START: u8 = 0x08;
    pub const STOP: u8 = 0x0A;
    pub const RDATAC: u8 = 0x10;
    pub const SDATAC: u8 = 0x11;
    pub const RDATA: u8 = 0x12;
    pub const RREG: u8 = 0x20;
    pub const WREG: u8 = 0x40;
}

/// What a channel's converter is connected to, as its register wants it: powered, gain 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum AdcInput {
    /// Its pins: the element.
    Pins = 0x10,
    /// Both on one potential inside the chip.
    Shorted = 0x11,
    /// The chip's supply, in parts: see [`SUPPLY_CODES`].
    Supply = 0x13,
}

/// Codes that [`AdcInput::Supply`] gives at the board's nominal supplies: half of AVDD (5.0 V) less
/// AVSS on channels 1, 2, 5 and 6, a quarter of DVDD (3.3 V) on 3 and 4 (data sheet SBAS561,
/// "supply measurement").
pub const SUPPLY_CODES: [i32; CHANNELS] = {
    const ANALOG: i32 = (2.5 / VOLT_PER_CODE) as i32;
    const DIGITAL: i32 = (0.825 / VOLT_PER_CODE) as i32;
    [ANALOG, ANALOG, DIGITAL, DIGITAL, ANALOG, ANALOG]
};

/// The chip on its SPI device, with its reset pin.
#[derive(Debug)]
pub struct Ads131e06<SPI, RST, D> {
    spi: SPI,
    reset: RST,
    delay: D,
    /// Of each channel, as measured with its inputs shorted; taken off the codes of every frame.
    offsets: [i32; CHANNELS],
    /// What each of [`Register::SET`] should hold.
    written: [u8; Register::SET.len()],
}

impl<SPI: SpiDevice, RST: OutputPin, D: DelayNs> Ads131e06<SPI, RST, D> {
    /// The chip as it is, before [`initialise`](Self::initialise). `reset` is active low.
    pub const fn new(spi: SPI, reset: RST, delay: D) -> Self {
        Self { spi, reset, delay, offsets: [0; CHANNELS], written: [0; Register::SET.len()] }
    }

    /// Brings the chip from any state to continuous conversion at `rate`. Takes 0.4 s (4 kSPS) or
    /// 0.5 s (1 kSPS).
    ///
    /// # Errors
    /// Another chip or none, a register that does not hold what was written, a data-ready line that
    /// stays where it is, an offset beyond [`OFFSET_LIMIT`], or a bus or pin that failed. The chip
    /// then sends no conversions.
    pub fn initialise(&mut self, rate: DataRate, data_ready: &mut impl InputPin) -> Result<(), AdcError> {
        self.reset().map_err(|_| AdcError::ResetPin)?;
        // After a reset the chip sends data of its own accord, and would take no register command.
        self.command(command::SDATAC)?;
        let mut identity = [0];
        self.access(command::RREG, 1, Operation::TransferInPlace(&mut identity))?;
        if identity != [IDENTITY] {
            return Err(AdcError::WrongChip { identity: identity[0] });
        }

        self.write_register(Register::Config1, config1(rate))?;
        self.write_register(Register::Config2, 0xE0)?;
        // Reference buffer on, 4 V; the spare amplifier off.
        self.write_register(Register::Config3, 0xE0)?;
        self.write_register(Register::Fault, 0x00)?;
        self.connect(AdcInput::Shorted)?;
        self.read_back()?;

        self.delay.delay_ms(REFERENCE_MS);
        self.measure_offsets(rate, data_ready)?;

        self.connect(AdcInput::Pins)?;
        self.convert()
    }

    /// Changes the data rate of a chip that converts already. Takes 0.1 ms; the offsets are those
    /// of the modulators, and stay.
    ///
    /// # Errors
    /// A register that does not hold what was written, or a bus that failed. The chip is then not
    /// converting, or not at this rate; another call may find it better.
    pub fn set_rate(&mut self, rate: DataRate) -> Result<(), AdcError> {
        self.stop()?;
        self.write_register(Register::Config1, config1(rate))?;
        self.convert()
    }

    /// Connects all converters of a chip that converts already to something else. Takes 0.2 ms,
    /// after which conversions begin anew.
    ///
    /// # Errors
    /// A register that does not hold what was written, or a bus that failed. The chip is then not
    /// converting; another call may find it better.
    pub fn select(&mut self, input: AdcInput) -> Result<(), AdcError> {
        self.stop()?;
        self.connect(input)?;
        self.convert()
    }

    fn stop(&mut self) -> Result<(), AdcError> {
        self.command(command::SDATAC)?;
        self.command(command::STOP)
    }

    /// Converts from now on, with registers that hold what was written to them.
    fn convert(&mut self) -> Result<(), AdcError> {
        self.read_back()?;
        self.command(command::START)?;
        self.command(command::RDATAC)
    }

    /// Reads all registers back from a chip that converts, which goes on with that. Takes
    /// [`VERIFY_US`], between a frame and the next conversion.
    ///
    /// # Errors
    /// The first register that does not hold what was written to it, or a bus that failed.
    pub fn verify(&mut self) -> Result<(), AdcError> {
        self.command(command::SDATAC)?;
        let kept = self.read_back();
        self.command(command::RDATAC)?;
        kept
    }

    /// Reads the conversion that data-ready has announced: 21 bytes and the 2 µs before chip select
    /// may rise. Returns the code of each channel, its offset taken off; [`CODE_MAX`] and
    /// [`CODE_MIN`] stay what they are.
    ///
    /// # Errors
    /// A status word without its mark (the frame is shifted, late, or no chip responds), or a bus
    /// that failed.
    pub fn read_frame(&mut self) -> Result<[i32; CHANNELS], AdcError> {
        // DIN stays low while data come out, hence a transfer of zeros and not a read, whose filler
        // is the bus' choice.
        let mut bytes = [0; FRAME_BYTES];
        self.transaction(&mut [Operation::TransferInPlace(&mut bytes), Operation::DelayNs(DECODE_NS)])?;
        let mut codes = parse(&bytes)?;
        for (code, offset) in codes.iter_mut().zip(&self.offsets) {
            if (CODE_MIN + 1..CODE_MAX).contains(code) {
                *code -= offset;
            }
        }
        Ok(codes)
    }

    fn reset(&mut self) -> Result<(), RST::Error> {
        self.reset.set_high()?;
        self.delay.delay_ms(POWER_ON_MS);
        self.reset.set_low()?;
        self.delay.delay_us(RESET_LOW_US);
        self.reset.set_high()?;
        self.delay.delay_us(RESET_HIGH_US);
        Ok(())
    }

    fn connect(&mut self, input: AdcInput) -> Result<(), AdcError> {
        (0..CHANNELS as u8).try_for_each(|channel| self.write_register(Register::Channel(channel), input as u8))
    }

    /// Mean code of every channel with its inputs shorted; converts for the purpose and stops
    /// again.
    fn measure_offsets(&mut self, rate: DataRate, data_ready: &mut impl InputPin) -> Result<(), AdcError> {
        // The first conversion after it is settled.
        self.command(command::START)?;
        let mut sums = [0; CHANNELS];
        for _ in 0..OFFSET_CONVERSIONS {
            self.wait_for_conversion(rate, data_ready)?;
            for (sum, code) in sums.iter_mut().zip(self.read_on_demand()?) {
                *sum += code;
            }
            // It rises with the first clock of a frame.
            if matches!(data_ready.is_low(), Ok(true)) {
                return Err(AdcError::DataReadyLow);
            }
        }
        self.command(command::STOP)?;
        for (channel, (offset, sum)) in self.offsets.iter_mut().zip(sums).enumerate() {
            let mean = sum / OFFSET_CONVERSIONS;
            if mean.abs() > OFFSET_LIMIT {
                return Err(AdcError::Offset { channel: channel as u8, code: mean });
            }
            *offset = mean;
        }
        Ok(())
    }

    fn wait_for_conversion(&mut self, rate: DataRate, data_ready: &mut impl InputPin) -> Result<(), AdcError> {
        for _ in 0..LONGEST_PERIODS * rate.conversion_us() / LOOK_US {
            if matches!(data_ready.is_low(), Ok(true)) {
                return Ok(());
            }
            self.delay.delay_us(LOOK_US);
        }
        Err(AdcError::NoConversion)
    }

    fn read_on_demand(&mut self) -> Result<[i32; CHANNELS], AdcError> {
        let mut bytes = [0; FRAME_BYTES];
        self.transaction(&mut [
            Operation::Write(&[command::RDATA]),
            Operation::DelayNs(DECODE_NS),
            Operation::TransferInPlace(&mut bytes),
            Operation::DelayNs(DECODE_NS),
        ])?;
        parse(&bytes)
    }

    fn command(&mut self, opcode: u8) -> Result<(), AdcError> {
        self.transaction(&mut [Operation::Write(&[opcode]), Operation::DelayNs(DECODE_NS)])?;
        self.delay.delay_us(DESELECTED_US);
        Ok(())
    }

    fn write_register(&mut self, register: Register, value: u8) -> Result<(), AdcError> {
        let place = usize::from(register.address()).wrapping_sub(1);
        self.written.get_mut(place).into_iter().for_each(|written| *written = value);
        self.access(command::WREG | register.address(), 1, Operation::Write(&[value]))
    }

    /// Holds all registers against what was written to them.
    fn read_back(&mut self) -> Result<(), AdcError> {
        let mut values = [0; Register::SET.len()];
        let opcode = command::RREG | Register::Config1.address();
        self.access(opcode, Register::SET.len() as u8, Operation::TransferInPlace(&mut values))?;
        for ((register, written), read) in Register::SET.into_iter().zip(self.written).zip(values) {
            if (read ^ written) & register.mask() != 0 {
                return Err(AdcError::NotKept { register, written, read });
            }
        }
        Ok(())
    }

    /// Reads or writes so many registers from one on.
    fn access(&mut self, opcode: u8, count: u8, values: Operation<'_, u8>) -> Result<(), AdcError> {
        self.transaction(&mut [
            Operation::Write(&[opcode]),
            Operation::DelayNs(DECODE_NS),
            Operation::Write(&[count - 1]),
            Operation::DelayNs(DECODE_NS),
            values,
            Operation::DelayNs(DECODE_NS),
        ])?;
        self.delay.delay_us(DESELECTED_US);
        Ok(())
    }

    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), AdcError> {
        self.spi.transaction(operations).map_err(|_| AdcError::Spi)
    }
}

/// Bits 7 and 4 must be 1; no daisy chain, no clock output; data rate below.
const fn config1(rate: DataRate) -> u8 {
    0x90 | match rate {
        DataRate::Sps4000 => 0b100,
        DataRate::Sps1000 => 0b110,
    }
}

/// Status: 1100, eight bits for the positive pins, eight for the negative ones, four GPIO; then the
/// channels, high byte first.
fn parse(bytes: &[u8; FRAME_BYTES]) -> Result<[i32; CHANNELS], AdcError> {
    let (status, data) = bytes.split_at(3);
    let status = u32::from_be_bytes([0, status[0], status[1], status[2]]);
    if (status >> 20) as u8 != STATUS_MARK {
        return Err(AdcError::DamagedFrame { status });
    }
    let mut codes = [0; CHANNELS];
    for (code, bytes) in codes.iter_mut().zip(data.chunks_exact(3)) {
        // The code in the upper three bytes: shifting it down extends its sign.
        *code = i32::from_be_bytes([bytes[0], bytes[1], bytes[2], 0]) >> 8;
    }
    Ok(codes)
}

#[cfg(test)]
mod tests;
