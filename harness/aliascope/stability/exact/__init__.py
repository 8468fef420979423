"""What is true of small inputs, in whole numbers, fractions and mpmath: what probes hold results against."""
