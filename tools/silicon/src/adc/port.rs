//! Commands and frames, byte by byte (SBAS561, "SPI interface", "Commands").
//!
//! A frame is loaded into the shift register when its conversion is there (RDATAC) or when it is
//! asked for (RDATA). Data-ready rises with the first clock of it, and falls with the next
//! conversion.

use super::converter::{Converter, LOWEST};
use super::fault::AdcFault;
use super::registers::AdcRegisters;
use super::{CHANNELS, t_clk};
use crate::complaint::{BrokenRule, Complaints};
use crate::plant::SensorPlant;
use crate::soc::spi::SpiByte;
use crate::time::ms;

const SPI_MODE: u32 = 0b01;
const FASTEST_HZ: u64 = 20_000_000;
/// Start-up of the internal reference.
const REFERENCE_SETTLES: u64 = ms(150);
/// Status and six codes.
pub const FRAME_BYTES: usize = 3 + 3 * CHANNELS;
const MARK: u8 = 0xc0;

/// The chip.
#[derive(Clone, Debug)]
pub struct Adc {
    registers: AdcRegisters,
    converter: Converter,
    /// Frames leave by themselves.
    streams: bool,
    is_selected: bool,
    selected_until: u64,
    data_ready_low: bool,
    codes: [i32; CHANNELS],
    has_converted: bool,
    /// Frame that leaves, and how much of it has left.
    shift: Vec<u8>,
    left: usize,
    command: Vec<u8>,
    last_byte: u64,
    resets_since: Option<u64>,
    ready_at: u64,
    reference_since: Option<u64>,
    fault: Option<AdcFault>,
    random: u32,
    /// Bytes of the frame that leaves, what the faults have made of it.
    sent: [u8; FRAME_BYTES],
    /// Frames as they were on the bus, if somebody wants them.
    pub record: Option<Vec<[u8; FRAME_BYTES]>>,
    /// Frames read to their end.
    pub frames_read: u64,
    /// Conversions so far.
    pub conversions: u64,
}

impl Adc {
    /// A chip whose supply has risen at this time.
    pub fn powered_at(now: u64) -> Self {
        Self {
            registers: AdcRegisters::default(),
            converter: Converter::default(),
            streams: true,
            is_selected: false,
            selected_until: 0,
            data_ready_low: false,
            codes: [0; CHANNELS],
            has_converted: false,
            shift: Vec::new(),
            left: 0,
            command: Vec::new(),
            last_byte: 0,
            resets_since: None,
            ready_at: now + t_clk(1 << 18),
            reference_since: None,
            fault: None,
            random: 0xace1,
            sent: [0; FRAME_BYTES],
            record: None,
            frames_read: 0,
            conversions: 0,
        }
    }

    /// From now on it has this fault, or none.
    pub const fn set_fault(&mut self, fault: Option<AdcFault>) {
        self.fault = fault;
    }

    /// A register takes another value by itself.
    pub fn disturb_register(&mut self, address: usize, value: u8) {
        self.registers.set(address, value);
    }

    /// Tells whether data-ready is low.
    pub const fn data_ready_low(&self) -> bool {
        self.data_ready_low
    }

    /// Tells whether each conversion is sent as a frame; not while registers are read.
    pub const fn streams(&self) -> bool {
        self.streams
    }

    /// Tells whether chip select is low.
    pub const fn is_selected(&self) -> bool {
        self.is_selected
    }

    /// When the next conversion is there.
    pub fn next_event(&self) -> u64 {
        self.converter.next().unwrap_or(u64::MAX)
    }

    /// Converts; data-ready falls, unless the chip is silent. Returns whether it fell.
    pub fn convert(&mut self, now: u64, plant: &mut SensorPlant, complaints: &mut Complaints) -> bool {
        let codes = self.converter.convert(now, &self.registers, plant);
        self.conversions += 1;
        match self.fault {
            Some(AdcFault::Silent) => return false,
            Some(AdcFault::Stuck) => {}
            Some(AdcFault::LowEnd) => self.codes = [LOWEST; CHANNELS],
            _ => self.codes = codes,
        }
        self.has_converted = true;
        if self.streams {
            if self.is_selected && (1..FRAME_BYTES).contains(&self.left) {
                complaints.add(now, "ADC frame", BrokenRule::AdcFrameAcrossUpdate);
            }
            self.load_frame();
        }
        self.data_ready_low = true;
        true
    }

    fn load_frame(&mut self) {
        self.shift.clear();
        self.shift.extend_from_slice(&[MARK, 0, 0]);
        for code in self.codes {
            self.shift.extend_from_slice(&code.to_be_bytes()[1..]);
        }
        self.left = self.shift.len();
    }

    /// The reset pin.
    pub fn set_reset(&mut self, now: u64, is_low: bool, complaints: &mut Complaints) {
        match (self.resets_since, is_low) {
            (None, true) => {
                if now < self.ready_at {
                    complaints.add(now, "ADC RESET", BrokenRule::AdcResetTime);
                }
                self.resets_since = Some(now);
            }
            (Some(since), false) => {
                if now - since < t_clk(2) {
                    complaints.add(now, "ADC RESET", BrokenRule::AdcResetTime);
                }
                self.resets_since = None;
                self.reset(now);
            }
            _ => {}
        }
    }

    fn reset(&mut self, now: u64) {
        let fresh = Self::powered_at(now);
        *self = Self {
            is_selected: self.is_selected,
            ready_at: now + t_clk(18),
            fault: self.fault,
            record: self.record.take(),
            frames_read: self.frames_read,
            conversions: self.conversions,
            codes: self.codes,
            ..fresh
        };
    }

    /// The processor has let go of all pins, in the middle of whatever it was: no rule is broken.
    pub fn release(&mut self, now: u64) {
        (self.last_byte, self.selected_until) = (0, 0);
        self.select(now, false, &mut Complaints::default());
        (self.last_byte, self.selected_until) = (0, 0);
    }

    /// Chip select.
    pub fn select(&mut self, now: u64, is_low: bool, complaints: &mut Complaints) {
        if is_low == self.is_selected {
            return;
        }
        self.is_selected = is_low;
        if is_low {
            if now < self.selected_until + t_clk(2) && self.selected_until != 0 {
                complaints.add(now, "ADC CS", BrokenRule::AdcSelectTime);
            }
        } else {
            if now < self.last_byte + t_clk(4) {
                complaints.add(now, "ADC CS", BrokenRule::AdcDecodeTime);
            }
            self.selected_until = now;
            // A frame that was begun is not continued.
            self.command.clear();
            if self.left < self.shift.len() {
                self.left = 0;
            }
        }
    }

    /// The last frame that was read to its end, as it was on the bus.
    pub const fn last_frame(&self) -> &[u8; FRAME_BYTES] {
        &self.sent
    }

    /// A byte on the bus; gives what the chip sends meanwhile.
    pub fn exchange(&mut self, byte: SpiByte, plant: &mut SensorPlant, complaints: &mut Complaints) -> u8 {
        if !self.is_selected || self.resets_since.is_some() {
            return 0xff;
        }
        let SpiByte { at, sent, mode, clock_hz } = byte;
        if mode != SPI_MODE {
            complaints.add(at, "SPI1_CR1", BrokenRule::SpiMode);
        }
        if clock_hz > FASTEST_HZ {
            complaints.add(at, "SPI1_CR1", BrokenRule::AdcClock);
        }
        if at < self.ready_at {
            complaints.add(at, "ADC", BrokenRule::AdcResetTime);
        }
        if self.streams && self.left == 0 && sent == 0 && self.command.is_empty() {
            complaints.add(at, "ADC frame", BrokenRule::AdcNotReady);
        }
        let (is_frame, place) = (self.shift.len() == FRAME_BYTES && self.left > 0, self.shift.len() - self.left);
        let answer = self.shift_out(at, complaints);
        let answer = self.disturb(answer);
        if is_frame {
            self.sent[place] = answer;
            if self.left == 0 {
                self.record.iter_mut().for_each(|record| record.push(self.sent));
            }
        }
        let gap = at.saturating_sub(self.last_byte);
        self.last_byte = at;
        // While data leave, zeros go in: no command.
        if sent != 0 || !self.command.is_empty() {
            if !self.command.is_empty() && gap < t_clk(4) {
                complaints.add(at, "ADC command", BrokenRule::AdcDecodeTime);
            }
            self.command.push(sent);
            self.obey(at, plant, complaints);
        }
        answer
    }

    /// Disturbs a byte that is sent.
    fn disturb(&mut self, answer: u8) -> u8 {
        match self.fault {
            Some(AdcFault::Garbage) => {
                self.random = self.random >> 1 ^ if self.random & 1 == 1 { 0xa300_0000 } else { 0 };
                self.random as u8
            }
            Some(AdcFault::Dead) => 0xff,
            _ => answer,
        }
    }

    fn shift_out(&mut self, at: u64, complaints: &mut Complaints) -> u8 {
        if self.left == 0 {
            return 0;
        }
        let byte = self.shift[self.shift.len() - self.left];
        if self.left == FRAME_BYTES {
            self.data_ready_low = false;
            let settled = self.reference_since.is_some_and(|since| at >= since + REFERENCE_SETTLES);
            if !settled {
                complaints.add(at, "ADC CONFIG3", BrokenRule::AdcReference);
            }
        }
        self.left -= 1;
        if self.left == 0 && self.shift.len() == FRAME_BYTES {
            self.frames_read += 1;
        }
        byte
    }

    fn obey(&mut self, now: u64, plant: &mut SensorPlant, complaints: &mut Complaints) {
        let (opcode, length) = (self.command[0], self.command.len());
        match opcode {
            // WAKEUP and STANDBY are not used here; START and STOP.
            0x08 => {
                self.has_converted = false;
                self.converter.start(now, &self.registers, plant);
            }
            0x0a => self.converter.stop(),
            0x06 => self.reset(now),
            0x10 => self.streams = true,
            0x11 => {
                self.streams = false;
                self.left = 0;
            }
            0x12 => {
                if !self.has_converted {
                    complaints.add(now, "ADC RDATA", BrokenRule::AdcNoData);
                }
                self.load_frame();
            }
            0x20..=0x5f if self.streams => {
                complaints.add(now, "ADC command", BrokenRule::AdcRegisterWhileStreaming);
            }
            0x20..=0x3f => {
                let &[_, less_one] = self.command.as_slice() else { return };
                self.read_registers(usize::from(opcode & 0x1f), usize::from(less_one) + 1);
            }
            0x40..=0x5f => {
                let &[_, less_one, .., value] = self.command.as_slice() else { return };
                let index = length - 3;
                self.write_register(usize::from(opcode & 0x1f) + index, value, now, complaints);
                if index < usize::from(less_one) {
                    return;
                }
            }
            _ => complaints.add(now, "ADC command", BrokenRule::AdcCommand),
        }
        self.command.clear();
    }

    fn read_registers(&mut self, first: usize, count: usize) {
        self.shift.clear();
        let values = (first..first + count).map(|address| self.registers.get(address).unwrap_or(0));
        self.shift.extend(values);
        self.left = self.shift.len();
    }

    fn write_register(&mut self, address: usize, value: u8, now: u64, complaints: &mut Complaints) {
        if !self.registers.set(address, value) {
            complaints.add(now, "ADC command", BrokenRule::AdcCommand);
        }
        match (self.registers.has_reference(), self.reference_since) {
            (true, None) => self.reference_since = Some(now),
            (false, _) => self.reference_since = None,
            _ => {}
        }
    }
}
