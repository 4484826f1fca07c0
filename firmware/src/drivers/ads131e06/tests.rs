use super::*;
use embedded_hal_mock::eh1::delay::{CheckedDelay, NoopDelay, Transaction as Wait};
use embedded_hal_mock::eh1::digital::{Mock as Pin, State, Transaction as Edge};
use embedded_hal_mock::eh1::spi::{Mock as Spi, Transaction as Byte};

const SHORTED: u8 = 0x11;
const NORMAL: u8 = 0x10;
const COMMON_4K: [(u8, u8); 4] = [(0x01, 0x94), (0x02, 0xE0), (0x03, 0xE0), (0x04, 0x00)];

/// One transaction: chip select low, the bytes with 2 µs after each, chip select high.
fn selected(operations: impl IntoIterator<Item = Byte<u8>>) -> Vec<Byte<u8>> {
    let mut all = vec![Byte::transaction_start()];
    for operation in operations {
        all.extend([operation, Byte::delay(2_000)]);
    }
    all.push(Byte::transaction_end());
    all
}

fn command(opcode: u8) -> Vec<Byte<u8>> {
    selected([Byte::write_vec(vec![opcode])])
}

fn write(address: u8, value: u8) -> Vec<Byte<u8>> {
    selected([0x40 + address, 0x00, value].map(|byte| Byte::write_vec(vec![byte])))
}

fn read(address: u8, value: u8) -> Vec<Byte<u8>> {
    selected([
        Byte::write_vec(vec![0x20 + address]),
        Byte::write_vec(vec![0x00]),
        Byte::transfer_in_place(vec![0x00], vec![value]),
    ])
}

fn channels(value: u8) -> Vec<Byte<u8>> {
    (0x05..=0x0A).flat_map(|address| write(address, value)).collect()
}

/// All registers in one access, and what they hold.
fn read_all(values: [u8; 10]) -> Vec<Byte<u8>> {
    selected([
        Byte::write_vec(vec![0x21]),
        Byte::write_vec(vec![9]),
        Byte::transfer_in_place(vec![0; 10], values.to_vec()),
    ])
}

/// What the registers hold at this rate with all channels set to `input`.
fn registers(config1: u8, input: u8) -> [u8; 10] {
    [config1, 0xE0, 0xE0, 0x00, input, input, input, input, input, input]
}

/// A data-ready line that is low at every first look, high at every second.
struct Conversions(bool);

impl embedded_hal::digital::ErrorType for Conversions {
    type Error = core::convert::Infallible;
}

impl InputPin for Conversions {
    fn is_high(&mut self) -> Result<bool, Self::Error> {
        self.is_low().map(|low| !low)
    }
    fn is_low(&mut self) -> Result<bool, Self::Error> {
        self.0 = !self.0;
        Ok(self.0)
    }
}

/// One that stays where it is.
fn stuck(state: State, looks: usize) -> Pin {
    Pin::new(&vec![Edge::get(state); looks])
}

fn frame_bytes(status: [u8; 3], codes: [i32; CHANNELS]) -> Vec<u8> {
    let mut bytes = status.to_vec();
    bytes.extend(codes.iter().flat_map(|code| code.to_be_bytes()[1..].to_vec()));
    bytes
}

fn on_demand(codes: [i32; CHANNELS]) -> Vec<Byte<u8>> {
    selected([
        Byte::write_vec(vec![0x12]),
        Byte::transfer_in_place(vec![0; FRAME_BYTES], frame_bytes([0xC0, 0, 0], codes)),
    ])
}

fn frame(status: [u8; 3], codes: [i32; CHANNELS]) -> Vec<Byte<u8>> {
    selected([Byte::transfer_in_place(vec![0; FRAME_BYTES], frame_bytes(status, codes))])
}

fn reset_edges() -> [Edge; 3] {
    [Edge::set(State::High), Edge::set(State::Low), Edge::set(State::High)]
}

/// The whole start-up of a healthy chip whose shorted inputs give `offsets`.
fn start_up(config1: u8, offsets: [i32; CHANNELS]) -> Vec<Byte<u8>> {
    let mut common = COMMON_4K;
    common[0].1 = config1;
    let mut all = [command(0x11), read(0x00, 0xD1)].concat();
    all.extend(common.iter().flat_map(|&(address, value)| write(address, value)));
    all.extend(channels(SHORTED));
    all.extend(read_all(registers(config1, SHORTED)));
    all.extend(command(0x08));
    (0..OFFSET_CONVERSIONS).for_each(|_| all.extend(on_demand(offsets)));
    all.extend(command(0x0A));
    all.extend(channels(NORMAL));
    all.extend(read_all(registers(config1, NORMAL)));
    all.extend([command(0x08), command(0x10)].concat());
    all
}

fn initialise(bytes: &[Byte<u8>], rate: DataRate) -> (Result<(), AdcError>, Ads131e06<Spi<u8>, Pin, NoopDelay>) {
    let mut adc = Ads131e06::new(Spi::new(bytes), Pin::new(&reset_edges()), NoopDelay::new());
    let result = adc.initialise(rate, &mut Conversions(false));
    (result, adc)
}

fn done<D>(adc: Ads131e06<Spi<u8>, Pin, D>) {
    let Ads131e06 { mut spi, mut reset, .. } = adc;
    spi.done();
    reset.done();
}

/// What follows the checked part of a start-up that is refused: nothing.
fn refused(bytes: &[Byte<u8>], error: AdcError) {
    let (result, adc) = initialise(bytes, DataRate::Sps4000);
    assert_eq!(result, Err(error));
    done(adc);
}

/// An ADC that has been started without going through the start-up.
fn running(bytes: &[Byte<u8>], offsets: [i32; CHANNELS]) -> Ads131e06<Spi<u8>, Pin, NoopDelay> {
    let written = registers(0x94, NORMAL);
    Ads131e06 { spi: Spi::new(bytes), reset: Pin::new(&[]), delay: NoopDelay::new(), offsets, written }
}

#[test]
fn starts_up_byte_by_byte_at_4_ksps() {
    let (result, adc) = initialise(&start_up(0x94, [0; CHANNELS]), DataRate::Sps4000);
    assert_eq!(result, Ok(()));
    done(adc);
}

#[test]
fn starts_up_byte_by_byte_at_1_ksps() {
    let (result, adc) = initialise(&start_up(0x96, [0; CHANNELS]), DataRate::Sps1000);
    assert_eq!(result, Ok(()));
    done(adc);
}

#[test]
fn waits_as_long_as_the_data_sheet_wants() {
    let mut expected = vec![Wait::delay_ms(130), Wait::delay_us(10), Wait::delay_us(20)];
    // SDATAC, identity, 10 registers written and read at once, with chip select high for a while.
    expected.extend(vec![Wait::delay_us(1); 13]);
    // Reference, START; its first conversion comes when the line is looked at for the third time.
    expected.extend([Wait::delay_ms(200), Wait::delay_us(1), Wait::delay_us(5), Wait::delay_us(5)]);
    // STOP, six channels written and all registers read, START, RDATAC.
    expected.extend(vec![Wait::delay_us(1); 1 + 7 + 2]);
    let delay = CheckedDelay::new(&expected);
    let mut adc = Ads131e06::new(Spi::new(&start_up(0x94, [0; CHANNELS])), Pin::new(&reset_edges()), delay);
    let mut looks = vec![Edge::get(State::High); 2];
    looks.extend((0..OFFSET_CONVERSIONS).flat_map(|_| [Edge::get(State::Low), Edge::get(State::High)]));
    let mut line = Pin::new(&looks);
    adc.initialise(DataRate::Sps4000, &mut line).unwrap();
    line.done();
    adc.delay.done();
    done(adc);
}

#[test]
fn refuses_its_sister_chips_and_a_line_that_is_stuck() {
    for identity in [0xD0, 0xD2, 0x92, 0x00, 0xFF] {
        refused(&[command(0x11), read(0x00, identity)].concat(), AdcError::WrongChip { identity });
    }
}

#[test]
fn refuses_every_register_that_is_not_kept_by_name() {
    for (bad, register) in Register::SET.into_iter().enumerate() {
        let mut bytes = [command(0x11), read(0x00, 0xD1)].concat();
        bytes.extend(COMMON_4K.iter().flat_map(|&(address, value)| write(address, value)));
        bytes.extend(channels(SHORTED));
        let mut values = registers(0x94, SHORTED);
        let written = values[bad];
        values[bad] ^= 0x40;
        bytes.extend(read_all(values));
        assert_eq!(usize::from(register.address()), bad + 1);
        refused(&bytes, AdcError::NotKept { register, written, read: values[bad] });
    }
}

#[test]
fn refuses_an_input_that_stays_shorted() {
    let healthy = start_up(0x94, [0; CHANNELS]);
    // The last thing before START and RDATAC is the read-back.
    let mut values = registers(0x94, NORMAL);
    let kept = healthy.len() - command(0x08).len() - command(0x10).len() - read_all(values).len();
    values[9] = SHORTED;
    refused(
        &[healthy[..kept].to_vec(), read_all(values)].concat(),
        AdcError::NotKept { register: Register::Channel(5), written: NORMAL, read: SHORTED },
    );
}

#[test]
fn takes_either_value_of_the_undefined_bit_of_config3() {
    let mut bytes = start_up(0x94, [0; CHANNELS]);
    let mut values = registers(0x94, SHORTED);
    let healthy = read_all(values);
    values[2] |= 1;
    let at = bytes.windows(healthy.len()).position(|window| window == healthy).unwrap();
    bytes.splice(at..at + healthy.len(), read_all(values));
    let (result, adc) = initialise(&bytes, DataRate::Sps4000);
    assert_eq!(result, Ok(()));
    done(adc);
}

#[test]
fn measures_the_offsets_and_takes_them_off_every_code() {
    let offsets = [700, -700, 0, 1, -1, OFFSET_LIMIT];
    let bytes = [start_up(0x94, offsets), frame([0xC0, 0, 0], [1_000_000; CHANNELS])].concat();
    let (result, mut adc) = initialise(&bytes, DataRate::Sps4000);
    assert_eq!(result, Ok(()));
    assert_eq!(adc.offsets, offsets);
    assert_eq!(adc.read_frame().unwrap(), offsets.map(|offset| 1_000_000 - offset));
    done(adc);
}

#[test]
fn refuses_an_offset_that_no_healthy_channel_has() {
    for code in [OFFSET_LIMIT + 1, -OFFSET_LIMIT - 1] {
        let mut codes = [0; CHANNELS];
        codes[2] = code;
        let healthy = start_up(0x94, codes);
        let after_stop = channels(NORMAL).len() + read_all([0; 10]).len() + command(0x08).len() + command(0x10).len();
        refused(&healthy[..healthy.len() - after_stop], AdcError::Offset { channel: 2, code });
    }
}

#[test]
fn a_data_ready_line_that_stays_where_it_is_is_refused_and_nothing_hangs() {
    let healthy = start_up(0x94, [0; CHANNELS]);
    let first = healthy.windows(2).position(|window| window[1] == Byte::write_vec(vec![0x12])).unwrap();
    // Eight periods of 250 µs, looked at every 5 µs; and after the first conversion was read.
    let cases = [
        (State::High, 400, first, AdcError::NoConversion),
        (State::Low, 2, first + on_demand([0; CHANNELS]).len(), AdcError::DataReadyLow),
    ];
    for (state, looks, bytes, error) in cases {
        let mut adc = Ads131e06::new(Spi::new(&healthy[..bytes]), Pin::new(&reset_edges()), NoopDelay::new());
        let mut line = stuck(state, looks);
        assert_eq!(adc.initialise(DataRate::Sps4000, &mut line), Err(error));
        line.done();
        done(adc);
    }
}

#[test]
fn a_register_that_changes_while_it_converts_is_named_and_conversions_go_on() {
    for bad in [None, Some(0), Some(2), Some(9)] {
        let mut values = registers(0x94, NORMAL);
        if let Some(bad) = bad {
            values[bad] ^= 0x02;
        }
        let check = [command(0x11), read_all(values), command(0x10), frame([0xC0, 0, 0], [10; CHANNELS])];
        let mut adc = running(&check.concat(), [3; CHANNELS]);
        let expected = bad.map_or(Ok(()), |bad| {
            let (register, read) = (Register::SET[bad], values[bad]);
            Err(AdcError::NotKept { register, written: read ^ 0x02, read })
        });
        assert_eq!(adc.verify(), expected);
        assert_eq!(adc.read_frame().unwrap(), [7; CHANNELS]);
        done(adc);
    }
}

#[test]
fn changes_its_rate_byte_by_byte_and_keeps_the_offsets() {
    let change = [
        command(0x11),
        command(0x0A),
        write(0x01, 0x96),
        read_all(registers(0x96, NORMAL)),
        command(0x08),
        command(0x10),
        frame([0xC0, 0, 0], [10; CHANNELS]),
    ];
    let mut adc = running(&change.concat(), [3; CHANNELS]);
    adc.set_rate(DataRate::Sps1000).unwrap();
    assert_eq!(adc.read_frame().unwrap(), [7; CHANNELS]);
    done(adc);
}

#[test]
fn connects_all_channels_to_something_else_byte_by_byte_and_keeps_the_offsets() {
    for (input, register) in [(AdcInput::Shorted, 0x11), (AdcInput::Supply, 0x13), (AdcInput::Pins, 0x10)] {
        let change = [
            command(0x11),
            command(0x0A),
            channels(register),
            read_all(registers(0x94, register)),
            command(0x08),
            command(0x10),
            frame([0xC0, 0, 0], [10; CHANNELS]),
        ];
        let mut adc = running(&change.concat(), [3; CHANNELS]);
        adc.select(input).unwrap();
        assert_eq!(adc.read_frame().unwrap(), [7; CHANNELS]);
        done(adc);
    }
    // 2.5 V and 0.825 V of 4 V.
    assert_eq!(SUPPLY_CODES, [5_242_880, 5_242_880, 1_730_150, 1_730_150, 5_242_880, 5_242_880]);
}

#[test]
fn an_input_that_is_not_kept_is_refused_and_nothing_converts() {
    let mut values = registers(0x94, SHORTED);
    values[5] = NORMAL;
    let change = [command(0x11), command(0x0A), channels(SHORTED), read_all(values)];
    let mut adc = running(&change.concat(), [0; CHANNELS]);
    let error = adc.select(AdcInput::Shorted).unwrap_err();
    assert_eq!(error, AdcError::NotKept { register: Register::Channel(1), written: 0x11, read: 0x10 });
    done(adc);
}

#[test]
fn a_rate_that_is_not_kept_is_refused_and_nothing_converts() {
    let change = [command(0x11), command(0x0A), write(0x01, 0x94), read_all(registers(0x96, NORMAL))];
    let mut adc = running(&change.concat(), [0; CHANNELS]);
    let error = adc.set_rate(DataRate::Sps4000).unwrap_err();
    assert_eq!(error, AdcError::NotKept { register: Register::Config1, written: 0x94, read: 0x96 });
    done(adc);
}

#[test]
fn reads_codes_of_both_signs_and_the_ends_of_the_range() {
    // Data sheet, ideal output codes: 7FFFFFh at +FS, 000001h, 000000h, FFFFFFh, 800000h at −FS.
    let codes = [CODE_MAX, 1, 0, -1, CODE_MIN, -1_234_567];
    let mut adc = running(&frame([0xC0, 0, 0], codes), [0; CHANNELS]);
    assert_eq!(adc.read_frame(), Ok(codes));
    done(adc);
}

#[test]
fn the_ends_of_the_range_do_not_move_with_the_offset() {
    let codes = [CODE_MAX, CODE_MIN, CODE_MAX, CODE_MIN, CODE_MAX - 1, CODE_MIN + 1];
    let mut adc = running(&frame([0xC0, 0, 0], codes), [900, 900, -900, -900, 900, -900]);
    assert_eq!(adc.read_frame().unwrap(), [CODE_MAX, CODE_MIN, CODE_MAX, CODE_MIN, CODE_MAX - 901, CODE_MIN + 901]);
    done(adc);
}

#[test]
fn what_the_comparators_of_the_pins_and_the_gpio_say_changes_no_code() {
    let mut adc = running(&frame([0xC2, 0x11, 0x2F], [5; CHANNELS]), [0; CHANNELS]);
    assert_eq!(adc.read_frame(), Ok([5; CHANNELS]));
    done(adc);
}

#[test]
fn refuses_a_frame_without_its_mark() {
    // All low, all high, and a frame that is shifted by one bit.
    for status in [[0x00; 3], [0xFF; 3], [0x80, 0, 0], [0x60, 0, 0]] {
        let mut adc = running(&frame(status, [5; CHANNELS]), [0; CHANNELS]);
        let status = u32::from_be_bytes([0, status[0], status[1], status[2]]);
        assert_eq!(adc.read_frame(), Err(AdcError::DamagedFrame { status }));
        done(adc);
    }
}

#[test]
fn a_damaged_frame_while_measuring_the_offset_is_refused() {
    let mut bytes = start_up(0x94, [0; CHANNELS]);
    let first = bytes.windows(2).position(|window| window[1] == Byte::write_vec(vec![0x12])).unwrap();
    bytes.truncate(first);
    bytes.extend(selected([
        Byte::write_vec(vec![0x12]),
        Byte::transfer_in_place(vec![0; FRAME_BYTES], vec![0; FRAME_BYTES]),
    ]));
    refused(&bytes, AdcError::DamagedFrame { status: 0 });
}

/// A bus that works for a number of transactions and then fails.
struct Failing(usize);

impl embedded_hal::spi::ErrorType for Failing {
    type Error = embedded_hal::spi::ErrorKind;
}

impl SpiDevice for Failing {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        let Some(left) = self.0.checked_sub(1) else { return Err(embedded_hal::spi::ErrorKind::ModeFault) };
        self.0 = left;
        for operation in operations {
            if let Operation::TransferInPlace(bytes) = operation {
                bytes[0] = IDENTITY;
            }
        }
        Ok(())
    }
}

#[test]
fn reports_a_bus_that_fails() {
    // At SDATAC, at the identity, while writing, and while reading back.
    for transactions in [0, 1, 2, 12] {
        let mut adc = Ads131e06::new(Failing(transactions), Pin::new(&reset_edges()), NoopDelay::new());
        let error = adc.initialise(DataRate::Sps4000, &mut Conversions(false)).unwrap_err();
        assert_eq!(error, AdcError::Spi);
        assert_eq!(adc.read_frame(), Err(error));
        adc.reset.done();
    }
}

#[test]
fn names_a_reset_pin_that_fails() {
    let stuck =
        Edge::set(State::High).with_error(embedded_hal_mock::eh1::MockError::Io(std::io::ErrorKind::NotConnected));
    let mut adc = Ads131e06::new(Spi::new(&[]), Pin::new(&[stuck]), NoopDelay::new());
    let result = adc.initialise(DataRate::Sps4000, &mut Conversions(false));
    assert_eq!(result, Err(AdcError::ResetPin));
    done(adc);
}
