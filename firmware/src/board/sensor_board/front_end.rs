//! Readings in, levels out: the ADS131E06 on SPI1 with its data-ready on EXTI line 4, and the six
//! heater pins.
//!
//! **Who calls.** The control task is bound to EXTI4. The line raises it for each conversion (4 000
//! or 1 000 times a second); software raises it for commands, and 20 times a second for the health
//! task. Only the line's pending bit says that there is a conversion to be read. The bit is cleared
//! before the frame is read, so that an edge that comes meanwhile raises the task again; the bit
//! holds the interrupt until it is cleared, so it is cleared even while the ADC is out of use.
//!
//! **What is lost.** A frame without its mark, one that is read late, and an edge that
//! [`DataReady`] knows to be overdue count as conversions without codes: the tick keeps its length,
//! and the host is told their number. If the ADC falls silent, ticks go on in the same way with
//! readings that are missing. Without edges the task runs 20 times a second, so such a tick comes
//! up to 50 ms after its time, several at once if they are short. Codes whose last one is older
//! than a quarter of a tick by then are stale: levels stand for up to 7/4 of a tick, and no heater
//! is high by a reading of more than two. The guard trips within three ticks and 50 ms of the last
//! edge (its default limit).
//!
//! **Erases.** The processor stands still while a sector of the settings is erased. No tick is made
//! of the conversions of that time: they are counted as lost, and a tick begins anew.
//!
//! **What is checked.** After every 250th frame all registers of the ADC are read back: each 62.5
//! ms at 4 kSPS, each 250 ms at 1 kSPS. A difference trips.
//!
//! **How long.** A frame takes 168 bits at 10.5 MHz and 2 µs, about 20 µs with the handling of 21
//! bytes: in every conversion period of 250 µs, and 200 µs is what the decision may take
//! (`docs/reference/board.md`, "One tick").

use super::heaters_low;
use super::table::{ADC_CLOCK_KHZ, DataReadyPin, ELEMENTS, FIRST_PERIOD_US, HeaterPin, ResetPin, SelectPin};
use crate::mcu::stm32f4::clocks::{COUNTS_PER_US, CycleDelay, counts};
use crate::mcu::stm32f4::{dead_man::DeadManTimer, flash};
use dr_core::ConfigError;
use dr_core::control::{Cause, Tick};
use dr_core::sensor::reading::REFERENCE_CODE;
use dr_core::sensor::{FrontEndInput, Reading};
use embedded_hal::spi::MODE_1;
use embedded_hal_bus::spi::ExclusiveDevice;
use firmware::control_loop::ControlBoard;
use firmware::drivers::ads131e06::{self, Ads131e06};
use firmware::drivers::data_ready::{DataReady, Due};
use firmware::drivers::heater_pins::HeaterPins;
use firmware::drivers::settled_mean::SettledMean;
use firmware::drivers::tick_plan::{DataRate, TickPlan};
use stm32f4xx_hal::gpio::{Edge, PA5, PA6, PA7, Speed};
use stm32f4xx_hal::pac::{EXTI, SPI1, SYSCFG};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::spi::Spi;
use wire::ControlStatus;

/// A frame, 20, and by how much [`DataReady`] may be wrong about its begin: 4 for each conversion
/// that is served late one after the other, as while a model is taken in.
const FRAME_US: u32 = 60;
/// Frames from one read-back of the ADC's registers to the next.
const FRAMES_A_CHECK: u32 = 250;

type AdcDriver = Ads131e06<ExclusiveDevice<Spi<SPI1>, SelectPin, CycleDelay>, ResetPin, CycleDelay>;

/// Where the ADC is connected.
pub struct AdcPins {
    /// Chip select, high.
    pub select: SelectPin,
    /// SCK, MISO, MOSI.
    pub bus: (PA5, PA6, PA7),
    /// Falls when a conversion is ready.
    pub data_ready: DataReadyPin,
    /// Low resets; high.
    pub reset: ResetPin,
}

/// Readings of a tick, and levels for the next.
pub struct FrontEnd {
    adc: AdcDriver,
    line: DataReadyPin,
    heaters: HeaterPins<HeaterPin, ELEMENTS>,
    dead_man: DeadManTimer,
    /// Some heater has been set to the high level.
    any_high: bool,
    /// The ADC has been brought up: its reference is on and its offsets are known.
    usable: bool,
    /// The rate it converts at; `None` while it must not be believed.
    rate: Option<DataRate>,
    data_ready: DataReady,
    /// When the last frame was read.
    read_at: u32,
    /// When the edge came whose frame has completed a tick; none of a tick whose last conversion is
    /// lost.
    edge_at: Option<u32>,
    /// Longest time from there to the pins since the run began, counts.
    edge_to_pins: u32,
    mean: SettledMean<ELEMENTS>,
    plan: TickPlan,
    /// What the converters are connected to; none while they have not taken it.
    connected: Option<FrontEndInput>,
    /// The requested input.
    input: FrontEndInput,
    /// A conversion was overwritten before it was read.
    overran: bool,
    /// The edge that waits came while a frame or the registers were read: what is left of its own
    /// is no frame.
    torn: bool,
    /// Conversions without codes so far.
    lost: u32,
    /// Frames since the ADC's registers were read back.
    unchecked: u32,
    /// What that has found.
    fault: Option<Cause>,
}

impl FrontEnd {
    /// Brings the ADC up with ticks of 10 ms, so that standby senses already.
    #[expect(clippy::expect_used, reason = "start-up, before any heater is raised")]
    pub fn start(
        spi: SPI1,
        pins: AdcPins,
        mut exti: EXTI,
        syscfg: SYSCFG,
        heaters: HeaterPins<HeaterPin, ELEMENTS>,
        dead_man: DeadManTimer,
        rcc: &mut Rcc,
    ) -> Self {
        let plan = TickPlan::new(FIRST_PERIOD_US).expect("10 ms are 40 conversions");
        // High, since the bus takes its clock back from the pin: with a slower one at 84 MHz the last
        // bit of a byte may be that of the byte before (ES0182, 2.12.4).
        let (clock, data_in, data_out) = pins.bus;
        let clock = clock.into_alternate().speed(Speed::High);
        let data_out = data_out.into_alternate().speed(Speed::Medium);
        let bus = Spi::new(spi, (Some(clock), Some(data_in), Some(data_out)), MODE_1, ADC_CLOCK_KHZ.kHz(), rcc);
        let device =
            ExclusiveDevice::new(bus, pins.select, CycleDelay).expect("writing a pin of this processor cannot fail");
        let mut adc = Ads131e06::new(device, pins.reset, CycleDelay);
        let mut line = pins.data_ready;
        let started = adc.initialise(plan.rate(), &mut line);
        let usable = started
            .inspect_err(|error| defmt::error!("all readings are missing, the ADC did not start: {}", error))
            .is_ok();

        line.make_interrupt_source(&mut syscfg.constrain(rcc));
        line.trigger_on_edge(&mut exti, Edge::Falling);
        // Edges of the ADC's start.
        line.clear_interrupt_pending_bit();
        line.enable_interrupt(&mut exti);
        Self {
            adc,
            line,
            heaters,
            dead_man,
            any_high: false,
            usable,
            rate: usable.then_some(plan.rate()),
            data_ready: expectation(plan),
            read_at: counts(),
            edge_at: None,
            edge_to_pins: 0,
            mean: SettledMean::new(plan),
            plan,
            connected: Some(FrontEndInput::Element),
            input: FrontEndInput::Element,
            overran: false,
            torn: false,
            lost: 0,
            unchecked: 0,
            fault: None,
        }
    }

    /// Begins a tick anew after an erase, whose conversions are lost.
    fn resume(&mut self) {
        let now = counts();
        while self.data_ready.next(now, false) == Due::Lost {
            self.lost = self.lost.wrapping_add(1);
        }
        // Of some conversion during the erase.
        self.clear_edge();
        self.data_ready = expectation(self.plan);
        self.begin_tick();
    }

    fn begin_tick(&mut self) {
        self.mean.restart();
        self.overran = false;
    }

    /// Whether a conversion waits. Edges of an ADC that must not be believed are taken away.
    fn has_edge(&mut self) -> bool {
        let edge = self.line.check_interrupt();
        if edge && self.rate.is_none() {
            self.clear_edge();
        }
        edge && self.rate.is_some()
    }

    /// The codes of the edge that waits.
    fn read_frame(&mut self, now: u32) -> Option<[i32; ELEMENTS]> {
        if self.clear_edge() {
            self.overran = true;
            return None;
        }
        let codes = self.adc.read_frame();
        // An edge that has come meanwhile has changed the rest of the frame.
        self.torn = self.line.check_interrupt();
        codes.ok().filter(|_| !self.torn).inspect(|_| self.read_at = now)
    }

    /// Takes the edge that waits; returns whether its frame was spoilt by the reading of another.
    fn clear_edge(&mut self) -> bool {
        self.line.clear_interrupt_pending_bit();
        core::mem::take(&mut self.torn)
    }
}

impl ControlBoard<ELEMENTS> for FrontEnd {
    fn poll(&mut self) -> Option<[Reading; ELEMENTS]> {
        if flash::HAS_ERASED.take() {
            self.resume();
        }
        loop {
            // The time before the line: an edge that is not seen was not there at that time.
            let now = counts();
            let edge = self.has_edge();
            let lateness = self.data_ready.lateness(now);
            let codes = match self.data_ready.next(now, edge) {
                Due::Wait => return None,
                Due::Lost => {
                    self.overran |= edge;
                    None
                }
                Due::Late => {
                    self.clear_edge();
                    None
                }
                Due::Read => self.read_frame(now),
            };
            match codes {
                Some(_) => self.unchecked += 1,
                None => self.lost = self.lost.wrapping_add(1),
            }
            self.edge_at = codes.map(|_| now.wrapping_sub(lateness));
            if let Some(mut readings) = self.mean.conversion(codes.as_ref()) {
                if now.wrapping_sub(self.read_at) > self.plan.tick_us() / 4 * COUNTS_PER_US {
                    readings =
                        readings.map(|reading| if reading == Reading::Missing { reading } else { Reading::Stale });
                }
                if self.input == FrontEndInput::Reference {
                    scale_supplies(&mut readings);
                }
                return Some(readings);
            }
            if self.unchecked >= FRAMES_A_CHECK
                && self.data_ready.leaves(counts(), (FRAME_US + ads131e06::VERIFY_US) * COUNTS_PER_US)
            {
                self.unchecked = 0;
                self.fault = self.adc.verify().err().map(|_| Cause::AdcRegister);
                // What was converted meanwhile is no frame: it was not streamed.
                self.torn |= self.line.check_interrupt();
            }
        }
    }

    fn apply(&mut self, tick: &Tick<ELEMENTS>) -> bool {
        self.any_high = tick.heaters.0 != 0;
        self.dead_man.decided(self.any_high);
        let is_applied = self.heaters.apply(tick.heaters, &mut CycleDelay).is_ok();
        let took = self.edge_at.map_or(0, |edge_at| counts().wrapping_sub(edge_at));
        self.edge_to_pins = self.edge_to_pins.max(took);
        is_applied
    }

    fn holds_levels(&mut self) -> bool {
        self.heaters.verify().is_ok()
    }

    /// Of a tick that knows both levels nothing is kept.
    fn lower(&mut self) -> bool {
        self.heaters.all_low().ok();
        self.dead_man.decided(false);
        if self.any_high && self.has_edge() {
            // This conversion is of before.
            self.clear_edge();
            self.data_ready.next(counts(), true);
        }
        if self.any_high {
            self.begin_tick();
        }
        core::mem::take(&mut self.any_high)
    }

    /// Has the converters read something else from now on, for a self-test. It begins a tick anew:
    /// the one that goes on is longer by as much as has passed of it, some 0.3 ms with the change.
    /// A converter that does not accept it reads missing, which the test reports.
    fn select(&mut self, input: FrontEndInput) {
        if self.connected == Some(input) || !self.usable {
            return;
        }
        let connect = match input {
            FrontEndInput::Element => ads131e06::AdcInput::Pins,
            FrontEndInput::Shorted => ads131e06::AdcInput::Shorted,
            FrontEndInput::Reference => ads131e06::AdcInput::Supply,
        };
        self.input = input;
        // A converter that has not accepted it is set again after the next tick; its readings are
        // missing until then.
        self.connected = self.adc.select(connect).ok().map(|()| input);
        self.rate = self.connected.map(|_| self.plan.rate());
        // An edge of what was read before.
        self.clear_edge();
        self.data_ready = expectation(self.plan);
        self.mean = SettledMean::new(self.plan);
    }

    fn restart(&mut self) {
        self.begin_tick();
        self.edge_to_pins = 0;
    }

    /// Plans ticks of another length; an ADC that has to change its rate does so in 0.1 ms.
    ///
    /// One that does not take its new rate is no error here: its readings are missing from now on,
    /// which the guard sees.
    ///
    /// # Errors
    /// A period that is no whole number of conversions, or under four of them.
    fn set_sample_period(&mut self, sample_period_s: f32) -> Result<(), ConfigError> {
        let plan = TickPlan::from_seconds(sample_period_s)?;
        // An ADC that keeps its rate keeps the times of its conversions.
        if self.rate != Some(plan.rate()) {
            let taken = self.usable && self.adc.set_rate(plan.rate()).is_ok();
            self.rate = (taken && self.connected.is_some()).then_some(plan.rate());
            // An edge of the old rate.
            self.clear_edge();
            self.data_ready = expectation(plan);
        }
        self.mean = SettledMean::new(plan);
        self.plan = plan;
        self.dead_man.set_tick(plan.tick_us());
        self.overran = false;
        Ok(())
    }

    /// Whether a conversion came before the tick was through, or was lost since the last time of
    /// asking.
    fn overran(&mut self) -> bool {
        core::mem::take(&mut self.overran) || self.line.check_interrupt()
    }

    fn take_fault(&mut self) -> Option<Cause> {
        self.fault.take()
    }

    fn report(&self, status: &mut ControlStatus) {
        status.lost_conversions = self.lost;
        status.edge_to_pins_us = self.edge_to_pins / COUNTS_PER_US;
    }

    fn heaters_low(&mut self) {
        heaters_low();
    }
}

/// The supplies' codes in parts of what they should be: [`REFERENCE_CODE`] for one that is right.
fn scale_supplies(readings: &mut [Reading; ELEMENTS]) {
    for (reading, nominal) in readings.iter_mut().zip(ads131e06::SUPPLY_CODES) {
        if let Reading::Code(code) = reading {
            *code = (i64::from(*code) * i64::from(REFERENCE_CODE) / i64::from(nominal.max(1))) as i32;
        }
    }
}

/// Conversions of this plan from an ADC that starts now.
fn expectation(plan: TickPlan) -> DataReady {
    DataReady::new(plan.rate().conversion_us() * COUNTS_PER_US, FRAME_US * COUNTS_PER_US, counts())
}
