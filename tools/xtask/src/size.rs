//! Flash and RAM that the firmware takes, and what must not be linked into it.
//!
//! flash = all that is stored: vector table, code, constants and initial values of `.data`. RAM =
//! `.data` + `.bss` + `.uninit`; what is left is the stack's. Buffers for telemetry are sized by
//! the wish for speed, not by need, so they are shown apart and are no part of the budget; they are
//! known by their name.

use crate::artefacts::{self, FirmwareBoard};
use crate::{install, stated};
use anyhow::{Context, Result, bail};
use image_analysis::symbols::{Image, ImageSection, ImageSymbol};

const KIB: u64 = 1024;
/// Budget of the image, of 960 KiB that the settings leave it.
const FLASH_BUDGET: u64 = 512 * KIB;
/// Budget of static RAM without the telemetry buffers, of 128 KiB; nearly all of it is one head of
/// 16 elements and eight surfaces: network, amplitudes, elements, a self-test, ticks that wait for
/// their estimates.
const RAM_BUDGET: u64 = 44 * KIB;
const RAM: u64 = 128 * KIB;
/// A static whose own name contains this, in any case, is a telemetry buffer.
const TELEMETRY: &str = "telemetry";
/// Names that give away what firmware must do without: float formatting (about 10 KiB) and an
/// allocator.
const FORBIDDEN: [(&str, &str); 7] = [
    ("core::fmt::float", "formatting of floats"),
    ("flt2dec", "formatting of floats"),
    ("grisu", "formatting of floats"),
    ("dragon", "formatting of floats"),
    ("__rust_alloc", "allocation"),
    ("__rg_", "allocation"),
    ("alloc::", "allocation"),
];
const NUMBERS: &str = "docs/reference/numbers.md";
const DMA_PAGE: &str = "docs/reference/board-firmware.md";
/// Statics that the DMA fills and empties, and what stands before their size.
const DMA_BUFFERS: [(&str, &str); 2] =
    [("TELEMETRY_RECEIVED", "priority very high, "), ("TELEMETRY_FRAME", "priority medium, ")];
/// Number of the largest symbols that are shown for each memory.
const SHOWN: usize = 8;

struct Usage {
    flash: u64,
    ram: u64,
    telemetry: u64,
}

pub fn run() -> Result<()> {
    install::thumb_target()?;
    let mut faults = Vec::new();
    for board in FirmwareBoard::ALL {
        let image = Image::read(&artefacts::firmware(board)?)?;
        let usage = usage(&image);
        print(board, &image, &usage);
        if board == FirmwareBoard::Sensor {
            faults.extend(compare(&image, &usage).err().map(|fault| format!("{fault:#}")));
        }
        faults.extend(judge(&image, &usage).into_iter().map(|fault| format!("{}: {fault}", board.feature())));
    }
    if !faults.is_empty() {
        bail!("{}", faults.join("; "));
    }
    Ok(())
}

fn usage(image: &Image) -> Usage {
    let sum = |chosen: fn(&ImageSection) -> bool| {
        image.sections.iter().filter(|section| chosen(section)).map(|section| section.size).sum()
    };
    let telemetry =
        symbols(image, true).into_iter().filter(|symbol| is_telemetry(&symbol.name)).map(|symbol| symbol.size);
    Usage { flash: sum(|section| section.stored), ram: sum(|section| section.writable), telemetry: telemetry.sum() }
}

/// Symbols of RAM, or of flash only, the largest first.
fn symbols(image: &Image, writable: bool) -> Vec<&ImageSymbol> {
    let is_there = |index: usize| image.sections[index].writable == writable;
    let mut symbols: Vec<&ImageSymbol> =
        image.symbols.iter().filter(|symbol| symbol.size > 0 && symbol.section.is_some_and(is_there)).collect();
    symbols.sort_by(|a, b| b.size.cmp(&a.size).then_with(|| a.name.cmp(&b.name)));
    symbols
}

fn is_telemetry(name: &str) -> bool {
    name.rsplit("::").next().is_some_and(|last| last.to_ascii_lowercase().contains(TELEMETRY))
}

fn judge(image: &Image, usage: &Usage) -> Vec<String> {
    let mut faults = Vec::new();
    if usage.flash > FLASH_BUDGET {
        faults.push(format!("the image takes {} bytes of flash, {FLASH_BUDGET} are allowed", usage.flash));
    }
    let ram = usage.ram - usage.telemetry;
    if ram > RAM_BUDGET {
        faults.push(format!("statics take {ram} bytes of RAM without telemetry buffers, {RAM_BUDGET} are allowed"));
    }
    for (mark, what) in FORBIDDEN {
        if let Some(symbol) = image.symbols.iter().find(|symbol| symbol.name.contains(mark)) {
            faults.push(format!("{what} is linked in: {}", symbol.name));
        }
    }
    faults
}

/// Compares the sensor board's image with its pages.
fn compare(image: &Image, usage: &Usage) -> Result<()> {
    let kib = |bytes: u64| bytes as f64 / KIB as f64;
    let measured = [kib(usage.flash), kib(usage.ram - usage.telemetry)];
    stated::check(NUMBERS, "| ≤ 512 KiB; ≤ 44 KiB | ", &measured)?;
    for (name, before) in DMA_BUFFERS {
        let buffers = symbols(image, true);
        let buffer = buffers.iter().find(|symbol| symbol.name.ends_with(name)).with_context(|| format!("no {name}"))?;
        stated::check(DMA_PAGE, before, &[buffer.size as f64])?;
    }
    Ok(())
}

fn print(board: FirmwareBoard, image: &Image, usage: &Usage) {
    println!("\n{}", board.feature());
    for section in &image.sections {
        let place = match (section.stored, section.writable) {
            (true, true) => "flash and RAM",
            (true, false) => "flash",
            _ => "RAM",
        };
        println!("  {:<16} {:>8}  {place}", section.name, section.size);
    }
    let line = |what: &str, bytes: u64, budget: u64| {
        println!("  {what:<40} {bytes:>8} of {budget} bytes ({:.0} %)", 100.0 * bytes as f64 / budget as f64)
    };
    line("flash", usage.flash, FLASH_BUDGET);
    line("static RAM without telemetry buffers", usage.ram - usage.telemetry, RAM_BUDGET);
    println!("  {:<40} {:>8}", "telemetry buffers", usage.telemetry);
    println!("  {:<40} {:>8}", "left for the stack", RAM.saturating_sub(usage.ram));
    for (memory, writable) in [("flash", false), ("RAM", true)] {
        println!("  largest in {memory}");
        for symbol in symbols(image, writable).iter().take(SHOWN) {
            let mark = if writable && is_telemetry(&symbol.name) { "  (telemetry)" } else { "" };
            println!("    {:>8}  {}{mark}", symbol.size, symbol.name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image() -> Image {
        let section = |name: &str, size, stored, writable| ImageSection {
            name: name.into(),
            size,
            stored,
            content: Vec::new(),
            writable,
        };
        let symbol = |name: &str, size, section| ImageSymbol { name: name.into(), size, section: Some(section) };
        Image {
            sections: vec![
                section(".text", 1000, true, false),
                section(".data", 20, true, true),
                section(".bss", 300, false, true),
            ],
            symbols: vec![
                symbol("app::TELEMETRY_QUEUE", 200, 2),
                symbol("telemetry::COUNTERS", 8, 2),
                symbol("app::main", 500, 0),
            ],
        }
    }

    #[test]
    fn initialised_statics_count_in_both_memories_and_telemetry_is_known_by_its_own_name() {
        let image = image();
        let usage = usage(&image);
        assert_eq!((usage.flash, usage.ram, usage.telemetry), (1020, 320, 200));
        assert!(judge(&image, &usage).is_empty());
    }

    #[test]
    fn an_image_with_float_formatting_is_refused_by_name() {
        let mut image = image();
        image.symbols[2].name = "core::num::flt2dec::to_shortest_str".into();
        assert_eq!(
            judge(&image, &usage(&image)),
            ["formatting of floats is linked in: core::num::flt2dec::to_shortest_str"]
        );
    }

    #[test]
    fn an_image_beyond_its_budget_is_refused_with_both_numbers() {
        let mut image = image();
        image.sections[0].size = FLASH_BUDGET;
        // The initial values of `.data` lie in the flash as well.
        assert_eq!(
            judge(&image, &usage(&image)),
            [format!("the image takes {} bytes of flash, {FLASH_BUDGET} are allowed", FLASH_BUDGET + 20)]
        );
    }
}
