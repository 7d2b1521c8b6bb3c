"""check_skips.py on what ctest writes."""
import io
import pathlib
import tempfile
import unittest

import check_skips

PASSED = '<testcase name="A.Passes" status="run"><system-out>Skipped</system-out></testcase>'


def skipped(reason, name="A.Skips"):
    return (f'<testcase name="{name}" status="notrun"><skipped message="SKIP_REGULAR_EXPRESSION_MATCHED"/>'
            f"<system-out>[ RUN      ] {name}\n/x/a_test.cpp:12: Skipped\n{reason}\n\n[  SKIPPED ] {name}</system-out>"
            "</testcase>")


class CheckSkips(unittest.TestCase):
    def check(self, *cases, has=True, sanitized=False):
        machine = [(r"lacks avx512", lambda: has)]
        with tempfile.TemporaryDirectory() as folder:
            results = pathlib.Path(folder) / "results.xml"
            results.write_text(f"<testsuite>{''.join(cases)}</testsuite>")
            self.said = io.StringIO()
            return check_skips.check([results], machine, sanitized, self.said)

    def test_tests_that_ran_are_no_skips(self):
        self.assertEqual(self.check(PASSED), 0)
        self.assertEqual(self.said.getvalue(), "")

    def test_a_skip_is_allowed_where_the_machine_lacks_the_thing(self):
        self.assertEqual(self.check(PASSED, skipped("this processor lacks avx512"), has=False), 0)
        self.assertIn("skipped: A.Skips: this processor lacks avx512", self.said.getvalue())

    def test_the_same_skip_fails_where_the_machine_has_it(self):
        self.assertEqual(self.check(skipped("this processor lacks avx512")), 1)
        self.assertIn("must not", self.said.getvalue())

    def test_an_unknown_reason_and_none_at_all_fail(self):
        missing = '<testcase name="A.Missing" status="notrun"><skipped message="Unable to find executable"/></testcase>'
        self.assertEqual(self.check(skipped("not today"), missing, has=False), 2)
        self.assertIn("A.Missing: no reason given", self.said.getvalue())

    def test_counting_allocations_is_left_out_under_a_sanitizer_only(self):
        case = skipped("the sanitizer owns malloc")
        self.assertEqual(self.check(case, sanitized=True), 0)
        self.assertEqual(self.check(case), 1)

    def test_the_probes_of_this_machine_run(self):
        for words, has_it in check_skips.MACHINE:
            with self.subTest(words):
                self.assertIsInstance(has_it(), bool)


if __name__ == "__main__":
    unittest.main()
