//! One frame: `COBS( version, sequence, message, CRC ) 0x00`.
//!
//! | field | bytes | meaning |
//! |---|---|---|
//! | version | 1 | [`VERSION`] |
//! | sequence | 2, little-endian | one more than that of the last message, sent or dropped |
//! | message | n | postcard encoding of `ToBoard` or `FromBoard` |
//! | CRC | 2, little-endian | CRC-16/IBM-SDLC of all of the above |
//!
//! COBS takes the zeros out, so that 0x00 ends a frame and nothing else: a receiver that lost its
//! place finds the next frame at the next zero.

use crate::cobs::{Stuffed, unstuff};
use crate::version::VERSION;
use crc::{CRC_16_IBM_SDLC, Crc, Table};
use postcard::ser_flavors::crc::CrcModifier;
use serde::{Serialize, de::DeserializeOwned};

/// Longest frame, terminator included. The longest message is the status of 16 elements with
/// margins.
pub const MAX_FRAME: usize = 256;

const CHECK: Crc<u16, Table<1>> = Crc::<u16, Table<1>>::new(&CRC_16_IBM_SDLC);
static CRC: Crc<u16, Table<1>> = CHECK;

const HEADER: usize = 3;
const CHECKSUM: usize = 2;

/// Why a frame was not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameError {
    /// Not COBS, too short, wrong checksum, or no message although the checksum is right.
    Damaged,
    /// In order, but from another version of this protocol.
    Version(u8),
}

#[derive(Serialize)]
struct FrameLayout<'a, T> {
    version: u8,
    #[serde(with = "postcard::fixint::le")]
    sequence: u16,
    message: &'a T,
}

/// Writes a frame into `buffer` and returns the part that is to be sent, terminator included.
///
/// # Errors
/// If the buffer is too short; one of [`MAX_FRAME`] never is.
pub fn encode<'a, T: Serialize>(sequence: u16, message: &T, buffer: &'a mut [u8]) -> Result<&'a [u8], postcard::Error> {
    let frame = FrameLayout { version: VERSION, sequence, message };
    postcard::serialize_with_flavor(&frame, CrcModifier::new(Stuffed::new(buffer)?, CRC.digest()))
}

/// Takes apart a frame without its terminator, in place: sequence number and message.
///
/// # Errors
/// As [`FrameError`] says.
#[inline(always)] // a message is moved once less
pub fn decode<T: DeserializeOwned>(frame: &mut [u8]) -> Result<(u16, T), FrameError> {
    let length = unstuff(frame).ok_or(FrameError::Damaged)?;
    let content = frame.get(..length).ok_or(FrameError::Damaged)?;
    let (checked, checksum) = content.split_last_chunk::<CHECKSUM>().ok_or(FrameError::Damaged)?;
    if CRC.checksum(checked) != u16::from_le_bytes(*checksum) {
        return Err(FrameError::Damaged);
    }
    let (&[version, low, high], message) = checked.split_first_chunk::<HEADER>().ok_or(FrameError::Damaged)?;
    if version != VERSION {
        return Err(FrameError::Version(version));
    }
    let (message, rest) = postcard::take_from_bytes(message).map_err(|_| FrameError::Damaged)?;
    if rest.is_empty() { Ok((u16::from_le_bytes([low, high]), message)) } else { Err(FrameError::Damaged) }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::counters::LinkCounters;
    use crate::list::{List, MOST_ELEMENTS, Name};
    use crate::message::{
        BoardKind, ControlStatus, Crash, CrashKind, FromBoard, Identity, ObservedSample, Readings, ResetCause, Sample,
        Status, SurfaceValues, ToBoard, WindFrame, WindSample,
    };
    use dr_core::Command;
    use dr_core::control::{
        Cause, Controller, Drive, ElementConfig, FirstTrip, HardwareLimits, Heaters, Limits, Margins, Refusal,
        RunState, Trip, TripHistory,
    };
    use dr_core::model::{AlarmConfig, GainsConfig, NetworkSelfHeatingConfig, Reachability, SelfHeatingConfig};
    use dr_core::sensor::{Channel, Platinum, Reading};
    use dr_core::wind::{CardConfig, QualityFlags, WindCommand};
    use std::vec::Vec;

    fn bytes<T: Serialize>(sequence: u16, message: &T) -> Vec<u8> {
        encode(sequence, message, &mut [0; MAX_FRAME]).unwrap().to_vec()
    }

    #[test]
    fn levels_of_more_elements_than_a_board_has_are_not_sent() {
        let frame = |heaters| {
            let state = RunState::Running;
            let sample = Sample { tick: 0, heaters, valid: 0, state, temperature_c: List::new(), power_w: List::new() };
            encode(0, &FromBoard::Sample(sample), &mut [0; MAX_FRAME]).map(<[u8]>::len)
        };
        assert!(frame(Heaters(1 << 15)).is_ok() && frame(Heaters(1 << 16)).is_err());
    }

    #[test]
    fn the_longest_messages_fit() {
        let model = SelfHeatingConfig { mesh_rad_s: [1.7e38; 8], r_k_per_w: [-1.7e38; 8], reference_c: -1.7e38 };
        let sample = Sample {
            tick: u32::MAX,
            heaters: Heaters(u16::MAX.into()),
            valid: u16::MAX.into(),
            state: RunState::Tripped(Trip::of(15, Cause::Unreachable)),
            temperature_c: List::from_array([-1.7e38; MOST_ELEMENTS]),
            power_w: List::from_array([1.7e38; MOST_ELEMENTS]),
        };
        let equivalent_power_w = List::from_array([-1.7e38; MOST_ELEMENTS]);
        let wind = WindSample {
            quality_flags: QualityFlags(u16::MAX),
            wind_m_s: [-1.7e38; 3],
            speed_m_s: 1.7e38,
            across_m_s: 1.7e38,
            covariance_m2_s2: [1.7e38; 6],
            speed_error_m_s: 1.7e38,
            direction_error_rad: 3.1,
            chi_square: 1.7e38,
            gas_c: -1.7e38,
            conductance_w_k: SurfaceValues::from_array([1.7e38; 8]),
            raw_w_k: SurfaceValues::from_array([1.7e38; 8]),
        };
        let observed = ObservedSample { sample: sample.clone(), equivalent_power_w };
        let wind = WindFrame { tick: u32::MAX, interval_ticks: u16::MAX, wind };
        let firmware = Name::try_from("a firmware name of 32 characters").unwrap();
        assert_eq!(firmware.len(), firmware.capacity());
        let crash = Crash { kind: CrashKind::Fault, file: firmware.clone(), at: u32::MAX };
        let (board, reset) = (BoardKind::Virtual, ResetCause::Unknown);
        let (elements, order, unique_id) = (255, 255, [u32::MAX; 3]);
        let identity =
            Identity { firmware, board, elements, order, reset, starts: u32::MAX, crash: Some(crash), unique_id };
        let counters = LinkCounters {
            messages: u32::MAX,
            damaged: u32::MAX,
            oversized: u32::MAX,
            repeated: u32::MAX,
            lost: u32::MAX,
            foreign: u32::MAX,
        };
        let control = ControlStatus {
            state: RunState::Tripped(Trip::of(15, Cause::HostTimeout)),
            late_ticks: u32::MAX,
            missed_estimates: u32::MAX,
            lost_conversions: u32::MAX,
            bit_flips: u32::MAX,
            armed: true,
            edge_to_pins_us: u32::MAX,
            margins: List::from_array([Some(Margins { above_low_w: -1.7e38, below_high_w: 1.7e38 }); MOST_ELEMENTS]),
            history: TripHistory {
                trips: u32::MAX,
                is_locked: true,
                first: Some(FirstTrip { trip: Trip::of(15, Cause::HostTimeout), at_s: u32::MAX }),
            },
        };
        let (refused, unsent, deadlines) = (u32::MAX, u32::MAX, u32::MAX);
        let status = Status { uptime_s: u32::MAX, link: counters, refused, unsent, deadlines, control };
        let verdict = Reachability::HighLevelTooCold { most_rise_k: 1.7e38 };
        let refusal = Refusal::Unreachable { element: 255, target_c: -1.7e38, verdict };
        let readings = Readings::new(&[Reading::Code(-8_000_000); MOST_ELEMENTS]).unwrap();
        let own = NetworkSelfHeatingConfig {
            mesh_rad_s: [1.7e38; 8],
            r_k_per_w: [-1.7e38; 8],
            surface: [1.7e38; 8],
            rest_c: -1.7e38,
            gains: GainsConfig {
                correction_w_per_k: [1.7e38; 8],
                convection_w_per_k: 1.7e38,
                weights: [1.7e38; 2],
                variance_w2: 1.7e38,
            },
            alarm: Some(AlarmConfig { smoothing_s: 1.7e38, threshold_k: 1.7e38 }),
        };
        let card = CardConfig {
            mean: [1.7e38; 12],
            difference: [1.7e38; 12],
            along: [-1.7e38; 8],
            around: [-1.7e38; 8],
            seen: [-1.7e38; 8],
            mean_share: 1.7e38,
            difference_share: 1.7e38,
        };
        for message in [
            ToBoard::Command(Command::Wind(WindCommand::Card(card))),
            ToBoard::Command(Command::Model { element: 255, model }),
            ToBoard::Command(Command::Wind(WindCommand::SelfHeating { element: 255, config: own })),
            ToBoard::Readings(readings),
        ] {
            let mut frame = bytes(u16::MAX, &message);
            frame.pop();
            assert_eq!(decode::<ToBoard>(&mut frame), Ok((u16::MAX, message)));
        }
        let mut longest = 0;
        for message in [
            FromBoard::Identity(identity),
            FromBoard::Status(status),
            FromBoard::Sample(sample),
            FromBoard::Observed(observed),
            FromBoard::Wind(wind),
            FromBoard::Reply { to: u16::MAX, result: Err(refusal) },
        ] {
            let mut frame = bytes(u16::MAX, &message);
            longest = longest.max(frame.len());
            frame.pop();
            assert_eq!(decode::<FromBoard>(&mut frame), Ok((u16::MAX, message)));
        }
        // Not much more room than is needed: every link has a buffer of it.
        assert!((MAX_FRAME - 8..=MAX_FRAME).contains(&longest), "{longest}");
    }

    #[test]
    fn comes_back_as_it_was_sent() {
        let message = ToBoard::Command(Command::Drive { element: 3, drive: Drive::Power { power_w: 0.0125 } });
        let mut frame = bytes(0xbeef, &message);
        assert_eq!(frame.pop(), Some(0));
        assert!(!frame.contains(&0));
        assert_eq!(decode::<ToBoard>(&mut frame), Ok((0xbeef, message)));
    }

    /// A number that no constructor would let into a configuration can still come over a link.
    #[test]
    fn configurations_are_checked_again_where_they_arrive() {
        let channel = Channel::new(Platinum::linear(175.0, 0.0031).unwrap(), 4.768e-7, 3e-3, 16e-3).unwrap();
        let command = Command::Element { element: 0, config: ElementConfig { channel, limits: Limits::SPHERE_B } };
        let mut space = [0; 64];
        let sent = postcard::to_slice(&command, &mut space).unwrap().to_vec();
        for number in [175.0_f32, 0.0031, 4.768e-7, 3e-3, 16e-3, 50.0, 260.0, 70.0] {
            let place = sent.windows(4).position(|bytes| bytes == number.to_le_bytes()).unwrap();
            for bad in [f32::NAN, f32::INFINITY, -1e30] {
                let mut tampered = sent.clone();
                tampered[place..place + 4].copy_from_slice(&bad.to_le_bytes());
                let received: Command = postcard::from_bytes(&tampered).unwrap();
                let answer = Controller::<1>::new(&HardwareLimits::SIMULATED).handle(received);
                assert!(
                    matches!(answer, Err(Refusal::Invalid { element: Some(0), .. })),
                    "{number} as {bad}: {answer:?}"
                );
            }
        }
    }

    #[test]
    fn no_flipped_bit_gets_through() {
        let frame = bytes(7, &ToBoard::Telemetry { every: 300 });
        let content = &frame[..frame.len() - 1];
        for bit in 0..content.len() * 8 {
            let mut damaged = content.to_vec();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(decode::<ToBoard>(&mut damaged), Err(FrameError::Damaged), "bit {bit}");
        }
    }

    #[test]
    fn another_version_is_named() {
        // The version is the first byte behind the first COBS code; the checksum has to be made to
        // fit.
        for version in [VERSION - 1, VERSION + 1] {
            let mut content = std::vec![version, 0, 0, 0];
            content.extend(CRC.checksum(&content).to_le_bytes());
            let mut frame = std::vec![0; 16];
            let length = cobs::encode(&content, &mut frame);
            assert_eq!(decode::<ToBoard>(&mut frame[..length]), Err(FrameError::Version(version)));
        }
    }

    /// What any version has looked for since the first: COBS, the version in front, the CRC of all
    /// behind it.
    #[test]
    fn an_older_side_can_name_the_version_of_ours() {
        let mut frame = bytes(300, &ToBoard::Hello);
        assert_eq!(frame.pop(), Some(0));
        let length = cobs::decode_in_place(&mut frame).unwrap();
        let (checked, checksum) = frame[..length].split_last_chunk::<2>().unwrap();
        assert_eq!((checked[0], CRC.checksum(checked)), (VERSION, u16::from_le_bytes(*checksum)));
    }

    #[test]
    fn lists_are_as_long_as_there_are_elements() {
        let message = |elements: usize| {
            let of = |number: f32| std::iter::repeat_n(number, elements).collect::<List<f32>>();
            let (heaters, state) = (Heaters(3), RunState::Running);
            let sample = Sample { tick: 5, heaters, valid: 7, state, temperature_c: of(1.0), power_w: of(0.5) };
            (
                FromBoard::Sample(sample.clone()),
                FromBoard::Observed(ObservedSample { sample, equivalent_power_w: of(0.25) }),
            )
        };
        let mut space = [0; MAX_FRAME];
        for elements in [0, 1, 6, 13, 16] {
            let (sample, observed) = message(elements);
            let mut expected = std::vec![2, 5, 3, 7, 1];
            let add = |expected: &mut Vec<u8>, number: f32| {
                expected.push(elements as u8);
                expected.extend(std::iter::repeat_n(number.to_le_bytes(), elements).flatten());
            };
            add(&mut expected, 1.0);
            add(&mut expected, 0.5);
            assert_eq!(postcard::to_slice(&sample, &mut space).unwrap(), expected);
            expected[0] = 6;
            add(&mut expected, 0.25);
            assert_eq!(postcard::to_slice(&observed, &mut space).unwrap(), expected);
        }
    }

    #[test]
    fn a_list_of_more_elements_than_there_can_be_is_damage() {
        let readings = ToBoard::Readings(Readings::new(&[Reading::Code(1); MOST_ELEMENTS]).unwrap());
        let mut space = [0; 64];
        let mut content = postcard::to_slice(&readings, &mut space).unwrap().to_vec();
        assert_eq!(content[..3], [3, 0, MOST_ELEMENTS as u8]);
        content[2] += 1;
        content.extend([1, 0, 0]);
        assert!(postcard::from_bytes::<ToBoard>(&content).is_err());
    }

    #[test]
    fn the_command_to_observe_is_number_nine_and_comes_back() {
        let message = ToBoard::Command(Command::Observe { on: true });
        let mut space = [0; 8];
        assert_eq!(postcard::to_slice(&message, &mut space).unwrap(), [1, 9, 1]);
        let mut frame = bytes(4, &message);
        frame.pop();
        assert_eq!(decode::<ToBoard>(&mut frame), Ok((4, message)));
    }

    #[test]
    fn short_and_trailing_content_is_damage() {
        assert_eq!(decode::<ToBoard>(&mut []), Err(FrameError::Damaged));
        assert_eq!(decode::<ToBoard>(&mut [2, 1]), Err(FrameError::Damaged));
        #[derive(Serialize)]
        struct Longer(ToBoard, u8);
        let mut frame = bytes(0, &Longer(ToBoard::Hello, 1));
        frame.pop();
        assert_eq!(decode::<ToBoard>(&mut frame), Err(FrameError::Damaged));
    }
}
