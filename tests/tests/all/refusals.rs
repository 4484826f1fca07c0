//! Bad input, from outside: one sentence that says what is wrong and what would be right, exit code
//! 2 if it is the command or a file that it names, 1 if the work itself fails; nothing on stdout,
//! nothing left behind. (Boards at a serial port: `serial.rs`.)

use anemo_tests::Desk;

/// An experiment with one thing wrong is refused with this, by every instrument alike and before
/// any of them is touched.
fn is_refused(name: &str, from: &str, to: &str, expected: &str) {
    let desk = Desk::new(name, &[(from, to)]);
    for on in ["sim", "qemu", "serial:/dev/no-such-port"] {
        let (code, sentence) = desk.refused(
            &["run", "e.toml", "--on", on, "-o", "r.parquet", "--plot", "p.svg"],
            &[("ANEMO_QEMU", "no-such-emulator")],
        );
        assert_eq!(code, 2, "{to}: {sentence}");
        assert!(sentence.contains(expected), "{to}: {sentence}");
    }
}

#[test]
fn a_key_that_nobody_knows_is_answered_with_the_nearest() {
    is_refused(
        "gusts.toml",
        "intensity = 0.10",
        "intensty = 0.10",
        "e.toml, line 35: unknown key `intensty`; did you mean `intensity`?",
    );
    is_refused("gusts.toml", "models =", "model =", "e.toml, line 5: unknown key `model`; did you mean `models`?");
    is_refused("gusts.toml", "[support]", "[suport]", "unknown key `suport`; did you mean `support`?");
    is_refused("gusts.toml", "\"co2\"", "\"co3\"", "unknown choice `co3` for `species`; did you mean `co2`?");
}

#[test]
fn a_value_that_cannot_be_is_answered_with_what_can() {
    for (from, to, expected) in [
        ("pressure_pa = 1000.0", "pressure_pa = -1000.0", "`gas.pressure_pa` is -1000: it must be 1 to 200000 Pa"),
        ("pressure_pa = 1000.0", "pressure_pa = nan", "`gas.pressure_pa` is NaN"),
        ("temperature_c = -43.15", "temperature_c = nan", "`support.temperature_c` is NaN"),
        ("noise_v_rms = 1.5e-6", "noise_v_rms = nan", "`front_end.noise_v_rms` is NaN"),
        ("duration_s = 120.0", "duration_s = -120.0", "`duration_s` is -120 s: it must be finite and above 0 s"),
        ("power_w = 0.02", "power_w = inf", "`drives.sector2.power_w` is inf W: the levels of sector2 reach from"),
        ("seed = 4", "seed = 4.5", "`seed`: invalid type: floating point `4.5`"),
        (
            "azimuth_deg = 30.0",
            "azimuth_deg = \"north\"",
            "`azimuth_deg`: invalid type: string \"north\", expected a number",
        ),
        (
            "core2 = \"passive\"",
            "core2 = { level = \"high\", power_w = 0.01 }",
            "`core2`: exactly one choice belongs here",
        ),
    ] {
        is_refused("all-drives.toml", from, to, expected);
    }
}

#[test]
fn a_sample_period_that_does_not_divide_the_times_is_answered_with_times_that_it_does() {
    // 120 s are 15 000 periods of 8 ms, but a bit of 20 ms is two and a half.
    is_refused(
        "all-drives.toml",
        "sample_period_s = 0.01",
        "sample_period_s = 0.008",
        "`drives.sector3.prbs.bit_time_s` is 0.02 s, which is not a whole number of sample periods of 0.008 s: 0.016 s or 0.024 s would be",
    );
    is_refused(
        "steady.toml",
        "sample_period_s = 0.01",
        "sample_period_s = 0.007",
        "`duration_s` is 300 s, which is not a whole number",
    );
}

#[test]
fn a_file_that_is_not_there_or_none_is_named_where_it_is_asked_for() {
    is_refused("gusts.toml", "sphere-b.toml", "sphere-c.toml", "e.toml, line 4: `head` cannot be used: ");
    is_refused("gusts.toml", "sphere-b-mars-still.toml", "none.toml", "e.toml, line 5: `models` cannot be used: ");
    is_refused(
        "gusts.toml",
        "../heads/models/sphere-b-mars-still.toml",
        "..",
        "e.toml, line 5: `models` cannot be used: ",
    );
    is_refused(
        "gusts.toml",
        "../heads/models/sphere-b-mars-still.toml",
        "e.toml",
        "unknown key `drives`; known are `conditions`, `kinds`, `elements`",
    );
    is_refused("gusts.toml", "title = ", "\u{7}", "e.toml, line 3: ");
}

#[test]
fn a_set_point_out_of_reach_is_refused_before_anything_runs() {
    let drive = "sector2 = { temperature_c = -23.15 }";
    for (to, expected) in [
        (
            "sector2 = { temperature_c = 25.0 }",
            "`drives.sector2` asks for 25 °C, which cannot be held: at the high level it ends at",
        ),
        (
            "sector2 = { temperature_c = -44.0 }",
            "`drives.sector2` asks for -44 °C, which cannot be held: even at the low level it ends at",
        ),
    ] {
        is_refused("gusts.toml", drive, to, expected);
    }
}

#[test]
fn outputs_that_cannot_be_written_stop_the_run_before_it_begins() {
    let desk = Desk::new("gusts.toml", &[]);
    std::fs::create_dir(desk.path().join("folder.csv")).unwrap();
    for (output, expected) in [
        ("none/r.csv", "none/r.csv: cannot be written: there is no folder `none`"),
        // Closed to everybody, whatever their rights.
        ("/sys/r.csv", "/sys/r.csv: "),
        ("folder.csv", "folder.csv: cannot be written: it is a folder"),
        ("r.txt", "r.txt: a recording's name ends in .parquet or .csv"),
        (".csv", ".csv: a recording's name ends in .parquet or .csv"),
    ] {
        let (code, sentence) = desk.refused(&["run", "e.toml", "--on", "sim", "-o", output], &[]);
        assert_eq!(code, 2, "{sentence}");
        assert!(sentence.contains(expected), "{sentence}");
    }
    for (plot, expected) in
        [("none/p.svg", "none/p.svg: cannot be written: there is no folder `none`"), ("/sys/p.svg", "/sys/p.svg: ")]
    {
        let (code, sentence) = desk.refused(&["run", "e.toml", "--on", "sim", "-o", "r.csv", "--plot", plot], &[]);
        assert_eq!(code, 2, "{sentence}");
        assert!(sentence.contains(expected), "{sentence}");
    }
}

#[test]
fn an_emulator_that_is_not_installed_is_said_how_to_install() {
    let desk = Desk::new("gusts.toml", &[]);
    std::fs::write(desk.path().join("firmware.elf"), crashing_firmware()).unwrap();
    let run = ["run", "e.toml", "--on", "qemu", "--firmware", "firmware.elf", "-o", "r.parquet", "--plot", "p.svg"];
    let (code, sentence) = desk.refused(&run, &[("ANEMO_QEMU", "no-such-emulator")]);
    assert_eq!(code, 1);
    assert!(sentence.starts_with("`no-such-emulator` is not installed; install it with"), "{sentence}");
    let (code, sentence) = desk.refused(&run, &[("ANEMO_QEMU", "/")]);
    assert_eq!(code, 1);
    assert!(sentence.starts_with("the emulator `/` cannot be started: "), "{sentence}");
    // Something else by that name.
    let (code, sentence) = desk.refused(&run, &[("ANEMO_QEMU", "true")]);
    assert_eq!(code, 1);
    assert!(sentence.starts_with("the emulated board stopped with "), "{sentence}");
}

#[test]
fn a_firmware_that_is_none_or_not_there_is_named() {
    let desk = Desk::new("gusts.toml", &[]);
    let command = anemo_tests::anemo().display().to_string();
    std::fs::write(desk.path().join("empty.elf"), "").unwrap();
    for (firmware, expected) in [
        ("none.elf", "there is no firmware at none.elf; build it with"),
        ("e.toml", "e.toml is no firmware: an ELF image for ARM belongs here"),
        ("empty.elf", "empty.elf is no firmware: "),
        (".", ". is no firmware: "),
        (command.as_str(), " is no firmware: an ELF image for ARM belongs here"),
    ] {
        let (code, sentence) =
            desk.refused(&["run", "e.toml", "--on", "qemu", "--firmware", firmware, "-o", "r.csv"], &[]);
        assert_eq!(code, 1, "{sentence}");
        assert!(sentence.contains(expected), "{sentence}");
    }
}

#[test]
fn a_firmware_that_dies_is_quoted() {
    let desk = Desk::new("gusts.toml", &[]);
    std::fs::write(desk.path().join("crash.elf"), crashing_firmware()).unwrap();
    std::fs::write(desk.path().join("cut.elf"), &crashing_firmware()[..60]).unwrap();
    for firmware in ["crash.elf", "cut.elf"] {
        let (code, sentence) = desk
            .refused(&["run", "e.toml", "--on", "qemu", "--firmware", firmware, "-o", "r.csv", "--plot", "p.svg"], &[]);
        println!("{firmware}: {sentence}");
        assert_eq!(code, 1, "{sentence}");
        assert!(
            sentence.starts_with("the emulated board stopped with ") && sentence.contains("; its last words: qemu"),
            "{sentence}"
        );
    }
}

/// The smallest image for a Cortex-M: stack pointer, reset vector, and an undefined instruction
/// without a handler.
fn crashing_firmware() -> Vec<u8> {
    const FLASH: u32 = 0x0800_0000;
    const HEADERS: u32 = 52 + 32;
    let code: [u32; 5] = [0x2000_1000, FLASH + 16 + 1, 0, 0, 0xde00_de00];
    let length = 4 * code.len() as u32;
    let mut image = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0".to_vec();
    let halves = |words: &[u16]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    // An executable for ARM, of version 1, with one program header behind this one and no sections.
    image.extend(halves(&[2, 40]));
    image.extend(words(&[1, FLASH + 16 + 1, 52, 0, 0x0500_0200]));
    image.extend(halves(&[52, 32, 1, 40, 0, 0]));
    // Segments: what to load, from where in the file, to where.
    image.extend(words(&[1, HEADERS, FLASH, FLASH, length, length, 5, 4]));
    image.extend(words(&code));
    image
}
