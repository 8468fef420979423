"""A module that needs a library as it loads, which is not there."""

from __future__ import annotations

from aliascope.errors import NotAvailable

raise NotAvailable("libOSMesa.so.8 is not there")
