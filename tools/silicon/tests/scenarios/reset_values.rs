//! Registers after a power-on, by hand from RM0090: each chapter's register descriptions begin with
//! the reset value. Descriptions by machine (SVD) are wrong in some, as in PWR_CR.

use host_sim::sensor::SensorConfig;
use silicon::board::Board;
use silicon::plant::SensorPlant;
use silicon::processor::bus::ProcessorBus;

/// Base, chapter of RM0090, and registers: offset, name, reset value.
type Peripheral = (u32, &'static str, &'static [(u32, &'static str, u32)]);

const RCC: u32 = 0x4002_3800;

const PERIPHERALS: [Peripheral; 17] = [
    (
        RCC,
        "7, RCC of STM32F405xx",
        &[
            // The calibration of the internal oscillator, bits 8 to 15, is the chip's own.
            (0x00, "CR", 0x0000_0083),
            (0x04, "PLLCFGR", 0x2400_3010),
            (0x08, "CFGR", 0),
            (0x0c, "CIR", 0),
            (0x10, "AHB1RSTR", 0),
            (0x20, "APB1RSTR", 0),
            (0x24, "APB2RSTR", 0),
            // The core's own memory has its clock.
            (0x30, "AHB1ENR", 0x0010_0000),
            (0x40, "APB1ENR", 0),
            (0x44, "APB2ENR", 0),
            (0x74, "CSR", 0x0e00_0000),
        ],
    ),
    // VOS: scale 1, which 168 MHz need.
    (0x4000_7000, "5, PWR", &[(0x00, "CR", 0x0000_4000), (0x04, "CSR", 0)]),
    (
        0x4002_3c00,
        "3, FLASH",
        // OPTCR: of a board that has started before, brown-out level 3; by factory it ends in D.
        &[(0x00, "ACR", 0), (0x0c, "SR", 0), (0x10, "CR", 0x8000_0000), (0x14, "OPTCR", 0x0fff_aae1)],
    ),
    (0x4002_0000, "8, GPIOA", &port(0xa800_0000, 0x0c00_0000, 0x6400_0000)),
    (0x4002_0400, "8, GPIOB", &port(0x0000_0280, 0x0000_00c0, 0x0000_0100)),
    (0x4002_0800, "8, GPIOC", &port(0, 0, 0)),
    (
        0x4001_3800,
        "9, SYSCFG",
        &[(0x08, "EXTICR1", 0), (0x0c, "EXTICR2", 0), (0x10, "EXTICR3", 0), (0x14, "EXTICR4", 0)],
    ),
    (
        0x4001_3c00,
        "12, EXTI",
        &[(0x00, "IMR", 0), (0x04, "EMR", 0), (0x08, "RTSR", 0), (0x0c, "FTSR", 0), (0x14, "PR", 0)],
    ),
    (0x4002_6000, "10, DMA1", &[(0x00, "LISR", 0), (0x04, "HISR", 0)]),
    (0x4002_6088, "10, DMA1 stream 5", STREAM),
    (0x4002_60a0, "10, DMA1 stream 6", STREAM),
    (0x4000_0000, "18, TIM2", TIMER),
    (0x4000_0c00, "18, TIM5", TIMER),
    (0x4000_3000, "21, IWDG", &[(0x04, "PR", 0), (0x08, "RLR", 0x0fff), (0x0c, "SR", 0)]),
    (
        0x4000_4400,
        "30, USART2",
        &[(0x00, "SR", 0x00c0), (0x08, "BRR", 0), (0x0c, "CR1", 0), (0x10, "CR2", 0), (0x14, "CR3", 0)],
    ),
    (0x4001_3000, "28, SPI1", &[(0x00, "CR1", 0), (0x04, "CR2", 0), (0x08, "SR", 0x0002), (0x0c, "DR", 0)]),
    (0xe004_2000, "38, DBGMCU", &[(0x04, "CR", 0), (0x08, "APB1_FZ", 0)]),
];

const fn port(moder: u32, ospeedr: u32, pupdr: u32) -> [(u32, &'static str, u32); 7] {
    [
        (0x00, "MODER", moder),
        (0x04, "OTYPER", 0),
        (0x08, "OSPEEDR", ospeedr),
        (0x0c, "PUPDR", pupdr),
        (0x14, "ODR", 0),
        (0x20, "AFRL", 0),
        (0x24, "AFRH", 0),
    ]
}

const STREAM: &[(u32, &str, u32)] =
    &[(0x00, "CR", 0), (0x04, "NDTR", 0), (0x08, "PAR", 0), (0x0c, "M0AR", 0), (0x10, "M1AR", 0), (0x14, "FCR", 0x21)];

const TIMER: &[(u32, &str, u32)] = &[
    (0x00, "CR1", 0),
    (0x0c, "DIER", 0),
    (0x10, "SR", 0),
    (0x1c, "CCMR2", 0),
    (0x20, "CCER", 0),
    (0x24, "CNT", 0),
    (0x28, "PSC", 0),
    (0x2c, "ARR", u32::MAX),
    (0x34, "CCR1", 0),
    (0x40, "CCR4", 0),
    (0x50, "OR", 0),
];

#[test]
fn registers_are_after_a_power_on_as_the_reference_manual_has_them() {
    let mut board = Board::new(SensorPlant::new(&SensorConfig::default()).unwrap(), 32_000);
    let mut wrong = Vec::new();
    for (base, chapter, registers) in PERIPHERALS {
        for &(offset, name, expected) in registers {
            let value = board.load(base + offset, 4).unwrap();
            if value != expected {
                wrong.push(format!("{chapter}, {name}: {value:#010x}, not {expected:#010x}"));
            }
        }
        // The next one has its clock.
        for (offset, gates) in [(0x30, 0x0020_0007), (0x40, 0x1002_0009), (0x44, 0x5000)] {
            board.store(RCC + offset, 4, gates).unwrap();
        }
        // A clock takes some cycles to arrive.
        board.pass(board.now() + 100, false);
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert_eq!(board.complaints.all(), []);
}
