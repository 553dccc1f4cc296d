"""The complete list of ways in which the integration of a cell can end."""

NOT_COMPUTED = 0
BOUNDED = 1
STEADY = 2
HORIZON = 3
FELL = 4
UNRESOLVED = 5
INVALID = 6

#: code -> (name, meaning)
ENDINGS: dict[int, tuple[str, str]] = {
    NOT_COMPUTED: ("not_computed", "the cell has not been integrated"),
    BOUNDED: ("bounded", "both turning points were passed: the extreme tilts hold for all time"),
    STEADY: ("steady", "an exact steady motion with nothing to disturb it: there is nothing to measure"),
    HORIZON: ("horizon", "the duration was over before both turning points were passed"),
    FELL: ("fell", "the tilt reached fall_tilt"),
    UNRESOLVED: ("unresolved", "the estimated error stayed over the tolerance, or the steps were too many"),
    INVALID: ("invalid", "no such start: not finite, or outside the domain of a parameter"),
}
