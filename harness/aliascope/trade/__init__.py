"""What a unit of time buys: the trade of speed for accuracy, analysed from the rows of a comparison."""

from aliascope.trade.analysis import analyse
from aliascope.trade.records import QUANTISATION, Trade

__all__ = ["QUANTISATION", "Trade", "analyse"]
