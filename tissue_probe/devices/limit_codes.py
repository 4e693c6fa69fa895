"""Numbers that name a passed limit in the check of samples, and places of numbers that it keeps."""

#: Which limit was passed.
NONE, SATURATION, FORCE, RATE, TRAVEL, COMMAND, CURRENT, HEATING, STUCK, UNKNOWN = range(10)
#: Places of the state that is carried from block to block.
LAST_FORCE, POSITION, LOW, HIGH, HEAT, SINCE_KNOWN = range(6)
