"""How far an input can go before a result is wrong: probes of every component at every extreme, and their map."""
