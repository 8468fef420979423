"""What a unit of time buys: the trade of speed for accuracy, analysed from the rows of a comparison."""
