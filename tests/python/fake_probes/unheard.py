"""A module that does not load."""

import no_such_module_of_anybody  # type: ignore[import-not-found]  # noqa: F401
