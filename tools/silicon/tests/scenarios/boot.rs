//! From power-on to the first message.

use crate::rig::Rig;
use host_sim::instrument::InstrumentPort;
use silicon::machine::MachineConfig;
use silicon::time::{ms, seconds};
use wire::{BoardKind, FromBoard, Receiver, ResetCause};

#[test]
fn a_board_says_who_it_is_and_why_it_has_started_with_its_heaters_low() {
    let rig = Rig::new(&MachineConfig::default());
    let instrument = rig.instrument();
    let identity = instrument.identity().clone();
    assert_eq!((identity.board, identity.elements), (BoardKind::Sensor, 6));
    assert_eq!((identity.reset, identity.starts), (ResetCause::PowerOn, 1));
    assert_eq!(identity.crash, None);
    // ST's memory answers only where the memory protection allows it.
    let number = [b"anem", b"o-un", b"ique"].map(|word| u32::from_le_bytes(*word));
    assert_eq!(identity.unique_id, number);
    // Waiting times of the converter's start: 130 ms, 200 ms and 128 conversions.
    let booted_s = seconds(rig.machine().now());
    assert!((0.36..0.45).contains(&booted_s), "{booted_s}");
    assert_eq!(rig.machine().pins().len(), 1, "no heater has moved");
    rig.assert_no_complaint();
    assert!(rig.machine().log()[0].contains("on the sensor board, started by power-on"));
}

#[test]
fn two_starts_are_the_same_to_the_bit() {
    let digest = || {
        let rig = Rig::new(&MachineConfig::default());
        rig.machine().run_until(ms(600)).unwrap();
        let mut machine = rig.machine();
        let frames: Vec<_> = machine.board_mut().host.frames().collect();
        (machine.now(), machine.core_mut().emulated_blocks(), frames, machine.core_mut().ram().unwrap())
    };
    assert!(digest() == digest());
}

/// `Hello` and `Start`, recorded from version 6 of the wire protocol: the board shows at once that
/// it speaks another one, and obeys neither.
#[test]
fn a_host_of_another_version_is_answered_with_ours() {
    let rig = Rig::new(&MachineConfig::default());
    rig.machine().run_until(ms(600)).unwrap();
    rig.machine().board_mut().host.frames().for_each(drop);
    rig.machine().board_mut().receive(b"\x02\x06\x01\x01\x03\x44\xb7\x00\x03\x06\x01\x05\x01\x06\xba\x94\x00");
    rig.machine().run_for(ms(20)).unwrap();
    let (mut receiver, mut machine) = (Receiver::new(), rig.machine());
    let bytes: Vec<u8> = machine.board_mut().host.frames().flat_map(|(_, frame)| frame).collect();
    let messages: Vec<_> = bytes.iter().filter_map(|&byte| receiver.push::<FromBoard>(byte)).collect();
    assert!(messages.iter().any(|of| matches!(of.message, FromBoard::Identity(_))), "{messages:?}");
    assert!(!messages.iter().any(|of| matches!(of.message, FromBoard::Reply { .. })), "{messages:?}");
    let said = format!("the host speaks version 6 of the wire protocol, this board {}", wire::VERSION);
    assert!(machine.log().iter().any(|line| line.contains(&said)), "{:?}", machine.log());
}
