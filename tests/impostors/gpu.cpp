// Tests of impostors, to come.
