"""Frames, messages, and what is made from their definition."""

import random
import shutil
import subprocess
import sys
import tempfile
import unittest
import zlib
from binascii import crc_hqx
from pathlib import Path

from brace_drake.link.protocol.cobs import stuff, unstuff
from brace_drake.link.protocol.codec import (
    Decoder,
    Packet,
    longest_frame,
    make_codec,
    seal_fits,
)
from brace_drake.link.protocol.limits import SHARED, as_sent
from brace_drake.link.protocol.messages import (
    BY_NAME,
    MESSAGES,
    ORDERED,
    num_items,
)
from brace_drake.link.protocol.sequence import SOON_US, is_newer
from tools.write_protocol import (
    DOCUMENT,
    HEADER_FILE,
    fill_tables,
    format_header,
)

_LARGEST = {"u8": 2**8, "u16": 2**16, "u32": 2**32, "u64": 2**64}


def draw_values(message, stages, draw):
    """Random values of all fields, as they come back."""
    values = {}
    for field in message.fields:
        number = num_items(field, stages)
        if field.kind == "text":
            values[field.name] = "x" * draw.randrange(number + 1)
        elif field.kind == "f32":
            draws = [as_sent(draw.gauss(0, 50)) for _ in range(number)]
            values[field.name] = (
                tuple(draws) if field.count != (1, 0) else draws[0]
            )
        else:
            values[field.name] = draw.randrange(_LARGEST[field.kind])
    return values


class TestStuffing(unittest.TestCase):
    def test_known_encodings_of_the_article(self):
        cases = {
            b"": b"\x01",
            b"\0": b"\x01\x01",
            b"\0\0": b"\x01\x01\x01",
            b"\x11\x22\0\x33": b"\x03\x11\x22\x02\x33",
            bytes(range(1, 255)): b"\xff" + bytes(range(1, 255)),
            b"\0" + bytes(range(1, 255)): b"\x01\xff" + bytes(range(1, 255)),
            bytes(range(1, 256)): b"\xff" + bytes(range(1, 255)) + b"\x02\xff",
        }
        for data, stuffed in cases.items():
            self.assertEqual(stuff(data), stuffed)
            self.assertEqual(unstuff(stuffed), data)

    def test_any_bytes_come_back_and_hold_no_zero_in_between(self):
        draw = random.Random(1)
        for _ in range(2000):
            size = draw.choice([0, 1, 5, 253, 254, 255, 508, 509, 700])
            zeros = draw.choice([0.0, 0.01, 0.5])
            data = bytes(
                0 if draw.random() < zeros else draw.randrange(256)
                for _ in range(size)
            )
            stuffed = stuff(data)
            self.assertNotIn(0, stuffed)
            self.assertLessEqual(len(stuffed), size + size // 254 + 1)
            self.assertEqual(unstuff(stuffed), data)


class TestMessages(unittest.TestCase):
    def test_the_checksums_have_their_published_check_values(self):
        self.assertEqual(crc_hqx(b"123456789", 0xFFFF), 0x29B1)
        self.assertEqual(zlib.crc32(b"123456789"), 0xCBF43926)

    def test_every_message_comes_back_for_one_stage_and_for_three(self):
        draw = random.Random(2)
        for stages in (1, 3):
            codec = make_codec(stages)
            for message in MESSAGES:
                values = draw_values(message, stages, draw)
                frame = codec.encode(message.name, values, 65537, 2**40, 77)
                self.assertLessEqual(len(frame), longest_frame(stages))
                packet = codec.decode(frame[1:-1])
                self.assertEqual(packet[:3], (message.name, 1, 2**40))
                got = packet.values._asdict()
                if message.sealed:
                    self.assertTrue(seal_fits(packet, 77))
                    self.assertFalse(seal_fits(packet, 78))
                    values["seal"] = got["seal"]
                self.assertEqual(got, values)

    def test_every_single_bit_error_is_found(self):
        codec = make_codec(1)
        frame = codec.encode("STOP", {"cause": 2}, 5, 123456789)[1:-1]
        for i in range(8 * len(frame)):
            damaged = bytearray(frame)
            damaged[i // 8] ^= 1 << i % 8
            if 0 in damaged:
                continue
            self.assertIsInstance(codec.decode(bytes(damaged)), str)

    def test_a_message_of_another_size_is_none(self):
        # A payload for three stages, whole and with a good CRC.
        values = dict.fromkeys(
            ("state", "cause", "flags", "tick", "command", "rejected"), 1
        )
        values |= {
            "leg_length": (0.1,) * 18,
            "force": (0.0,) * 9,
            "marker": (0.0,) * 3,
        }
        frame = make_codec(3).encode("STATE", values, 1, 1)
        self.assertEqual(make_codec(1).decode(frame[1:-1]), "length")


class TestStream(unittest.TestCase):
    def setUp(self):
        self.codec = make_codec(1)
        self.frames = [
            self.codec.encode("STOP", {"cause": i}, i, 1000 * i)
            for i in range(1, 30)
        ]

    def causes(self, data, cut=None):
        decoder = Decoder(self.codec)
        found = []
        step = cut or len(data) or 1
        for at in range(0, len(data), step):
            found += decoder.feed(data[at : at + step])
        return [p.values.cause for p in found], decoder

    def test_it_does_not_matter_how_the_stream_is_cut(self):
        data = b"".join(self.frames)
        for cut in (1, 2, 7, 1000):
            self.assertEqual(self.causes(data, cut)[0], list(range(1, 30)))

    def test_noise_in_front_of_a_frame_does_not_cost_it(self):
        draw = random.Random(3)
        noise = bytes(draw.randrange(1, 256) for _ in range(5000))
        found, decoder = self.causes(noise + b"".join(self.frames), 13)
        self.assertEqual(found, list(range(1, 30)))
        self.assertEqual(decoder.num_bad, decoder.bad["long"])

    def test_a_damaged_frame_costs_no_other(self):
        for damage in (
            lambda f: f[:7] + b"\0" + f[8:],
            lambda f: f[:7] + f[9:],
            lambda f: f[:-1] + b"\x55",
            lambda f: b"\x55" + f[1:],
            lambda f: f[: len(f) // 2],
            lambda f: b"",
        ):
            frames = list(self.frames)
            frames[9] = damage(frames[9])
            found, _ = self.causes(b"".join(frames))
            lost = set(range(1, 30)) - set(found)
            self.assertLessEqual(lost, {10})

    def test_a_hello_changes_the_layout_on_a_host_that_connects_only(self):
        hello = dict.fromkeys(("model", "identity", "firmware", "units"), "x")
        names = ("nonce", "state", "capabilities", "rate_hz")
        hello |= dict.fromkeys(
            (*names, "length_resolution", "force_resolution", "force_range"), 1
        )
        data = self.codec.encode("HELLO", {**hello, "stages": 3}, 1, 1)
        values = {"rest": (0.0,) * 9, "lower": (0.0,) * 54}
        data += make_codec(3).encode(
            "GEOMETRY", {**values, "upper": (0.0,) * 54}, 2, 1
        )
        for follows in (False, True):
            decoder = Decoder(self.codec, follows)
            self.assertEqual(len(decoder.feed(data)), 1 + follows)

    def test_what_never_ends_takes_no_room(self):
        decoder = Decoder(self.codec)
        for _ in range(2000):
            decoder.feed(b"\x07" * 997)
        self.assertLessEqual(len(decoder._rest), longest_frame() + 997)
        self.assertEqual(decoder.num_bad, 1)


class TestWhatIsMadeFromTheDefinition(unittest.TestCase):
    def test_the_documents_tables_are_those_of_the_definition(self):
        text = DOCUMENT.read_text(encoding="utf-8")
        self.assertEqual(text, fill_tables(text))
        for message in MESSAGES:
            self.assertIn(f"### {message.name}\n", text)

    def test_the_line_takes_as_many_bytes_as_the_document_says(self):
        text = " ".join(DOCUMENT.read_text(encoding="utf-8").split())
        # Frames of 1 kHz without a zero to stuff: two delimiters, one code.
        rates = [
            make_codec(stages).size(name) + 12 + 2 + 3
            for stages in (1, 3)
            for name in ("STATE", "COMMAND")
        ]
        self.assertIn(
            "the states take {} kB/s, the commands {}: 1 Mbaud, or USB. At"
            " three stages they take {} and {} kB/s".format(*rates),
            text,
        )

    def test_words_of_one_number_keep_their_own_meanings(self):
        text, header = DOCUMENT.read_text(encoding="utf-8"), format_header()
        for number, name, meaning in (
            (3, "ARMED", "follows commands; the watchdog runs"),
            (3, "WATCHDOG", "no accepted command within the watchdog's period"),
            (3, "ESTOP_PRESSED", "the emergency stop is pressed"),
            (1, "CLAMPED", "the command was cut at a limit of force or rate"),
            (
                1,
                "LENGTH",
                "leg lengths, m; optional, see `capabilities` of hello",
            ),
            (1, "WRONG_STATE", "not in this state"),
        ):
            self.assertIn(f"| {number} | {name} | {meaning} |", text)
            self.assertIn(f"_{name} = {number}, /* {meaning} */", header)

    def test_the_committed_header_is_the_one_of_the_definition(self):
        self.assertEqual(
            HEADER_FILE.read_text(encoding="utf-8"), format_header()
        )

    def test_no_two_messages_share_a_code(self):
        codes = [m.code for m in MESSAGES]
        self.assertEqual(len(set(codes)), len(codes))


_FRAMES = """
#include <stdio.h>
#include "brace_protocol.h"
/* Frames as lines of hex in, the same made anew out, with size and seal. */
int main(void) {
  char line[4 * BRACE_LONGEST_FRAME];
  while (fgets(line, sizeof line, stdin)) {
    uint8_t chunk[2 * BRACE_LONGEST_FRAME], body[BRACE_LONGEST_FRAME];
    uint8_t frame[BRACE_LONGEST_FRAME];
    size_t size = 0;
    unsigned byte;
    for (char *c = line; sscanf(c, "%2x", &byte) == 1; c += 2)
      chunk[size++] = (uint8_t)byte;
    size_t length = brace_open_frame(chunk, size, body);
    if (length == 0) { puts("none"); continue; }
    size_t made = brace_make_frame(body, length, frame);
    for (size_t i = 1; i + 1 < made; ++i) printf("%02x", frame[i]);
    printf(" %lu %lu\\n", (unsigned long)brace_payload_size(body[1]),
           (unsigned long)brace_seal(body, length - 4, 77));
  }
  return 0;
}
"""

_ORDER = """
#include <stdio.h>
#include "brace_protocol.h"
/* Session, code, sequence and clock of messages in; whether each counts out. */
int main(void) {
  struct brace_newest newest = {0, 0};
  struct brace_header header = {BRACE_VERSION, 0, 0, 0};
  unsigned session, type, sequence;
  unsigned long long time_us;
  while (scanf("%u %u %u %llu", &session, &type, &sequence, &time_us) == 4) {
    header.type = (uint8_t)type;
    header.sequence = (uint16_t)sequence;
    header.time_us = time_us;
    printf("%d\\n", !BRACE_IS_ORDERED(header.type) ||
                     brace_is_newer(&newest, &header, session));
  }
  return 0;
}
"""
_BOUNDS = """
#include <stdio.h>
#include "brace_protocol.h"
int main(void) {
  printf("%s\\n");
  return 0;
}
"""


@unittest.skipUnless(shutil.which("cc"), "no C compiler")
class TestHeaderInC(unittest.TestCase):
    def run_program(self, text, stages, lines):
        with tempfile.TemporaryDirectory() as folder:
            source, program = Path(folder, "x.c"), Path(folder, "x")
            source.write_text(text)
            subprocess.run(
                ["cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-O1",
                 f"-DBRACE_STAGES={stages}", f"-I{HEADER_FILE.parent}",
                 str(source), "-o", str(program)],
                check=True,
            )  # fmt: skip
            text = "\n".join(lines) + "\n"
            done = subprocess.run(
                [program],
                input=text,
                capture_output=True,
                text=True,
                check=True,
            )
        return done.stdout.splitlines()

    def test_c_reads_and_makes_the_same_frames(self):
        draw = random.Random(4)
        for stages in (1, 3):
            codec, frames, expected = make_codec(stages), [], []
            for message in MESSAGES * 5:
                values = draw_values(message, stages, draw)
                frame = codec.encode(message.name, values, 9, 2**33, 77)[1:-1]
                frames.append(frame.hex())
                packet = codec.decode(frame)
                seal = packet.values.seal if message.sealed else None
                expected.append((frame.hex(), codec.size(message.name), seal))
            damaged = bytearray.fromhex(frames[0])
            damaged[3] ^= 0x10
            out = self.run_program(_FRAMES, stages, [*frames, damaged.hex()])
            self.assertEqual(out.pop(), "none")
            for line, (frame, size, seal) in zip(out, expected, strict=True):
                got = line.split()
                self.assertEqual(got[:2], [frame, str(size)])
                if seal is not None:
                    self.assertEqual(int(got[2]), seal)

    def test_the_bounds_of_limits_are_numbers_of_c(self):
        bounds = {
            f"BRACE_{limit.name.upper()}_{side}": value
            for limit in SHARED
            for side, value in (("LEAST", limit.least), ("MOST", limit.most))
        }
        text = _BOUNDS % ("%.9g " * len(bounds) + '", ' + ", ".join(bounds))
        text = text.replace('\\n");', ");")
        (line,) = self.run_program(text, 1, [])
        for found, value in zip(line.split(), bounds.values(), strict=True):
            self.assertEqual(as_sent(float(found)), as_sent(value))

    def test_c_and_python_agree_on_what_is_newer(self):
        draw = random.Random(5)
        lines, expected, newest = [], [], (0, 0)
        sequence, clock = 65_000, 0
        for i in range(4000):
            message = BY_NAME[draw.choice([*ORDERED, "HEARTBEAT"])]
            sequence += draw.choice((1, 1, 1, 2, 0, -1, -3, 2**15, -(2**15)))
            clock += draw.choice((1000, 1000, 0, -1000, SOON_US, SOON_US + 1))
            sequence, clock = sequence % 2**16, max(clock, 0)
            session = int(i >= 5)
            counts = not session or is_newer(sequence, clock, newest)
            if message.name not in ORDERED:
                counts = True
            elif counts:
                newest = sequence, clock
            expected.append(int(counts))
            lines.append(f"{session} {message.code} {sequence} {clock}")
        out = self.run_program(_ORDER, 1, lines)
        self.assertEqual([int(line) for line in out], expected)
        self.assertTrue(500 < sum(expected) < 3500)


class TestLightness(unittest.TestCase):
    def test_the_link_imports_neither_drake_nor_torch_nor_numba_nor_numpy(
        self,
    ):
        names = [
            f"{room}.{path.stem}".removesuffix(".__init__")
            for room in ("protocol", "device", "host")
            for path in (HEADER_FILE.parents[1] / room).glob("*.py")
        ]
        code = "import sys\n" + "\n".join(
            f"import brace_drake.link.{name}" for name in names
        )
        code += (
            "\nheavy = {'pydrake', 'torch', 'numba', 'numpy', 'scipy'}"
            "\nsys.exit(', '.join(heavy & set(sys.modules)) or 0)"
        )
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True
        )
        self.assertEqual(done.returncode, 0, done.stderr)


class TestPacket(unittest.TestCase):
    def test_a_packet_says_what_its_seal_covers(self):
        codec = make_codec(1)
        frame = codec.encode("ARM", {"nonce": 1}, 1, 1, 5)
        packet = codec.decode(frame[1:-1])
        self.assertIsInstance(packet, Packet)
        self.assertEqual(packet.values.seal, zlib.crc32(packet.sealed_bytes, 5))


if __name__ == "__main__":
    unittest.main()
