//! The image of the sensor board, unmodified, on models of its processor, converter and sensor: in
//! virtual time, to the bit the same each time.
//!
//! ```text
//!                       machine: from one time to the next, kept and put back
//!                          │
//!      processor ──────► board ──────► adc ──────► plant: host-sim's sensor
//!      instructions,     wires           │            ▲
//!      exceptions,         │             └ SPI, data-ready
//!      time                └► soc: clocks, flash, pins, DMA, timers, watchdog
//!                               │        heaters' pins ─┘
//!      host: stream ◄───────────┘ USART
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`processor`] | a Cortex-M4F: Unicorn, our interrupt controller, exceptions, SysTick, cycle counter |
//! | [`soc`] | RCC, flash, GPIO, EXTI, SPI1, USART2, DMA1, TIM5, IWDG, each a file |
//! | [`adc`] | the ADS131E06: commands, frames, timing, filter, faults |
//! | [`plant`] | the simulated sensor, levels in and codes out |
//! | [`board`] | address map, wires, events |
//! | [`machine`] | an image on its board |
//! | [`stream`] | the line as a host has it: the ordinary serial instrument runs on it |
//! | [`complaint`] | rules of the manuals that the firmware breaks |
//! | `register_log` | what the firmware does with registers, for `cargo xtask registers` |
//! | [`witness`] | holds the heaters' pins against what the board reports |
//! | [`image`], [`log`](mod@log) | the ELF file; its log as a probe reads it |
//!
//! **Time** is one count of cycles of 168 MHz ([`time`]); nothing looks at a clock of the computer.
//! A block of instructions is charged as a whole at its head, by a table of classes of
//! instructions, so interrupts come up to a block late.
//!
//! **Complaints.** A model that is used against its manual notes the cycle, the register and the
//! rule, and goes on. A scenario that ends with a complaint fails.
//!
//! **Use.** `cargo xtask test` builds the image and runs `tests/scenarios`. The program
//! `anemo-silicon` is a board in a process of its own; with it beside `anemo` in a build folder,
//! `anemo run experiments/held.toml --on silicon` runs any experiment on the image.
//!
//! ```no_run
//! use silicon::machine::{Machine, MachineConfig};
//! use silicon::time::ms;
//!
//! let image = "firmware-sensor-board.elf".as_ref();
//! let mut machine = Machine::power_on(image, &MachineConfig::default())?;
//! machine.run_until(ms(500))?;
//! for complaint in machine.board().complaints.all() {
//!     println!("{complaint}");
//! }
//! # Ok::<(), silicon::machine::MachineError>(())
//! ```
//!
//! **Speed** on one core of a small virtual machine, six elements with models: 7 times real time at
//! a tick of 10 ms; a start takes 0.1 s.
//!
//! **Tests.** `tests/rules.rs` breaks every rule once, register by register; `tests/scenarios` has
//! the image: boot, ticks, closed loop, every cause of the guard, crashes in each task, settings,
//! supply, self-test, the line, random lives, flipped bits, a minute of a run (`cargo xtask
//! campaign` for more of the last three). `equal_bits` hands the readings that the board has taken to
//! a controller in this process, and `against_qemu` runs images of the virtual board here and in
//! QEMU: both are equal to the bit. `verdicts` asks both cores of protection, faults, priorities and
//! SysTick, and `reset_values` holds registers against the reference manual.
//!
//! **Limits.** Where nobody else has said so, it agrees with our reading of the manuals
//! (`docs/reference/second-opinions.md`). No wait states, no contention for buses, of the errata
//! only two (a clock that arrives late, a slow pin of SCK), nothing analogue but the sensor.
//!
//! The GPL covers Unicorn and hence this crate's programs: it is published nowhere, and no other
//! crate may depend on it.

pub mod adc;
pub mod board;
pub mod complaint;
pub mod host_line;
pub mod image;
pub mod log;
pub mod machine;
pub mod plant;
pub mod processor;
mod register_log;
pub mod soc;
pub mod stream;
pub mod time;
pub mod witness;
