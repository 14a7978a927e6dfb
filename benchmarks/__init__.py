"""Measurements side by side in one run. They print; the tests do not time anything."""
