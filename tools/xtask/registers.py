"""Holds the registers that the sensor board's image uses against two descriptions of the STM32F405: ST's SVD, and the
crate `stm32f4`, whose authors have corrected it.

    registers.py SVD CRATE LOGS

Rules: the register exists; it is as wide as the access; it may be read or written; a reserved bit is written as it is
after a reset. `EXEMPTIONS` lists what breaks a rule for a reason, with the sentence that allows it.
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

# Registers of the core are in neither: QEMU judges them (`tools/silicon/tests/scenarios/verdicts.rs`).
CORE = range(0xE000_0000, 0xE004_0000)
MOST_EXEMPTIONS = 20

# Description, register, rule, and why it may be broken.
HALF_WORDS = "have to be accessed by half-words (16 bits) or words (32 bits)"
EXEMPTIONS = [
    ("SVD", "USART2_.*", "width 16", f"RM0090, 30.6: USART registers {HALF_WORDS}"),
    ("SVD", "SPI1_.*", "width 16", f"RM0090, 28.5: SPI registers {HALF_WORDS}"),
    ("SVD", "IWDG_.*", "width 16", f"RM0090, 21.4: IWDG registers {HALF_WORDS}"),
    (
        "SVD PAC",
        "SPI1_DR",
        "width 8",
        "RM0090, AHB/APB bridges: the bridge duplicates the 8-bit data to feed the 32-bit vector; of which 8-bit frames "
        "use the lower byte (28.5.4); the HAL writes bytes, too",
    ),
    (
        "SVD",
        "PWR_CR",
        "reserved 0x4000",
        "RM0090, \"PWR power control register (PWR_CR) for STM32F405xx/07xx\": VOS is bit 14, one after a reset",
    ),
    (
        "SVD PAC",
        "FLASH_OPTCR",
        "reserved 0x10",
        "RM0090, \"Flash option control register (FLASH_OPTCR)\": the reset value is 0x0FFF AAED, without bit 4, which "
        "\"must be kept cleared\"; both descriptions have 0x14",
    ),
]


class Register(NamedTuple):
    name: str
    bits: int
    reads: bool
    writes: bool
    reset: int
    defined: int


def number(text: str) -> int:
    # Some reset values of the SVD have leading zeros and no base.
    return int(text.replace("_", ""), 16 if text.startswith("00") else 0)


def from_svd(path: Path) -> dict[int, Register]:
    device = ElementTree.parse(path).getroot()
    peripherals = {of.findtext("name", ""): of for of in device.iter("peripheral")}
    found = {}
    for name, peripheral in peripherals.items():
        origin = peripherals[peripheral.get("derivedFrom", name)]
        for register in origin.iter("register"):
            access = register.findtext("access", "read-write")
            defined = sum(
                (1 << number(of.findtext("bitWidth", "0"))) - 1 << number(of.findtext("bitOffset", "0"))
                for of in register.iter("field")
            )
            address = number(peripheral.findtext("baseAddress", "")) + number(register.findtext("addressOffset", ""))
            found[address] = Register(
                f"{name}_{register.findtext('name')}",
                number(register.findtext("size", "")),
                access != "write-only",
                access != "read-only",
                number(register.findtext("resetValue", "")),
                defined,
            )
    return found


def from_crate(folder: Path) -> dict[int, Register]:
    found = {}
    instances = re.findall(r"pub type (\w+) = crate::Periph<(\w+)::RegisterBlock, (\w+)>", (folder / "mod.rs").read_text())
    blocks = {module: list(of_block(folder / module)) for _, module, _ in instances}
    for name, module, base in instances:
        for offset, register in blocks[module]:
            found[number(base) + offset] = register._replace(name=f"{name}_{register.name}")
    return found


def of_block(module: Path) -> Iterator[tuple[int, Register]]:
    """Registers of a block, and those of its clusters, which are blocks in a folder of their own."""
    source = module.with_suffix(".rs").read_text()
    documented = r"///0x(\w+)(?:\.\.0x(\w+))? - .*\n(?: *///.*\n)* *#\[inline\(always\)\]\n *pub const fn (\w+)"
    for start, end, name in re.findall(documented, source):
        elsewhere = re.search(rf"pub use crate::\w+::(\w+)::{name};", source)
        file = (module.parent / elsewhere[1] if elsewhere else module) / f"{name}.rs"
        # The same register by another name.
        if not file.exists():
            continue
        count = int(next(iter(re.findall(rf"\b{name}: \[\w+; (\d+)\]", source)), 1))
        first, stride = int(start, 16), (int(end, 16) - int(start, 16)) // count if end else 0
        inner = list(of_block(module / name)) if (module / name).is_dir() else [(0, of_file(file))]
        for i, (offset, register) in ((i, of) for i in range(count) for of in inner):
            yield first + i * stride + offset, register._replace(name=f"{register.name}{i if end else ''}")


def of_file(file: Path) -> Register:
    source = file.read_text()
    fields = set(re.findall(r"///Bits? (\d+)(?::(\d+))? - ", source))
    width, reset = re.search(r"RegisterSpec for \w+ {\s+type Ux = u(\d+)", source), re.search(r"RESET_VALUE: u\d+ = (\w+)", source)
    return Register(
        file.stem.upper(),
        number(width[1]) if width else 0,
        "crate::Readable for" in source,
        "crate::Writable for" in source,
        number(reset[1]) if reset else 0,
        sum({int(low): (2 << int(high or low)) - (1 << int(low)) for low, high in fields}.values()),
    )


def broken(register: Register | None, size: int, read: bool, ones: int, zeros: int) -> Iterator[str]:
    if register is None:
        yield "exists"
        return
    if register.bits != 8 * size:
        yield f"width {8 * size}"
    if read and not register.reads:
        yield "read"
    if ones | zeros and not register.writes:
        yield "written"
    reserved = ~register.defined & (1 << register.bits) - 1
    if wrong := reserved & (ones & ~register.reset | zeros & register.reset):
        yield f"reserved {wrong:#x}"


def main() -> None:
    svd, crate, logs = map(Path, sys.argv[1:])
    used: dict[tuple[int, int], list[int]] = {}
    for line in (line for log in sorted(logs.iterdir()) for line in log.read_text().splitlines()):
        address, size, *rest = map(number, line.split())
        of = used.setdefault((address, size), [0, 0, 0])
        of[:] = [before | new for before, new in zip(of, rest)]
    used = {(address, size): of for (address, size), of in used.items() if address not in CORE}
    left = list(EXEMPTIONS)
    wrong = []
    for source, registers in [("SVD", from_svd(svd)), ("PAC", from_crate(crate))]:
        for (address, size), (read, ones, zeros) in sorted(used.items()):
            register = registers.get(address) or registers.get(address & ~3)
            name = register.name if register else f"{address:#x}"
            for rule in broken(register, size, bool(read), ones, zeros):
                exemption = next((of for of in EXEMPTIONS if source in of[0] and re.fullmatch(of[1], name) and re.fullmatch(of[2], rule)), None)
                if exemption is None:
                    wrong.append(f"{source}: {name} at {address:#x}: {rule}")
                elif exemption in left:
                    left.remove(exemption)
    wrong += [f"{exemption}: nothing needs this exemption" for exemption in left]
    print(f"{len(used)} registers and widths, {len(EXEMPTIONS)} exemptions of {MOST_EXEMPTIONS}")
    if wrong or len(EXEMPTIONS) > MOST_EXEMPTIONS or not used:
        sys.exit("\n".join(["registers are used in ways that a description does not have:", *wrong]))


main()
