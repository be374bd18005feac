"""Messages with arguments, as FMI 2.0 passes them: the text is that of printf."""

import ctypes

import pytest

from stickslip.fmi import toolchain
from stickslip.fmucheck.running.calls import Callbacks

CALLS = {
    '"%d of %u"': "-3, 7u",
    '"%ld %lld %zu"': "-3000000000L, 1LL << 40, (unsigned long)5",
    '"%s|%10s|%-4s|%.2s"': '"word", "ten", "a", "cut off"',
    '"%g %.3f %e"': "0.1, 3.14159, -1e300",
    '"%d %g %s %g %d"': '1, 2.5, "three", 4.5, 5',
    '"%*d|%.*f|%05d|%+d|%x|%#o"': "5, 42, 2, 1.005, 7, 8, 255, 8",
    '"%c%%%c"': "'a', 'b'",
    '"%d %d %d %d %d %d %d %s"': '1, 2, 3, 4, 5, 6, 7, "eight"',
    '"plain"': "",
}


@pytest.fixture(scope="module")
def library():
    cases = "".join(
        f'case {i}: log(env, "a", 0, "b", {text}{", " * bool(given)}{given});\n'
        f"snprintf(out, 200, {text}{', ' * bool(given)}{given}); break;\n"
        for i, (text, given) in enumerate(CALLS.items())
    )
    source = (
        "#include <stdio.h>\n"
        "typedef void Log(void *, const char *, int, const char *, const char *, ...);\n"
        '__attribute__((visibility("default"))) void say(Log *log, void *env, int i, char *out);\n'
        f"void say(Log *log, void *env, int i, char *out) {{ switch (i) {{\n{cases}}} }}\n"
    )
    flags = ("-Wno-format", "-Wno-pedantic", "-Wno-error")
    return ctypes.CDLL(str(toolchain.shared_library("printf", {"say.c": source}, flags=flags)))


@pytest.mark.parametrize("i", range(len(CALLS)), ids=list(CALLS))
def test_a_message_is_formatted_as_by_printf(library, i):
    callbacks, out = Callbacks(), ctypes.create_string_buffer(200)
    library.say(callbacks.logger2, ctypes.c_void_p(callbacks.environment), i, out)
    (message,) = callbacks.messages
    assert message.text == out.value.decode()
    assert (message.category, message.status) == ("b", 0)
