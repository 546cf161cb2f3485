"""What a shot is read without: one line for each kind of thing."""
import handover

MOST_NAMED = 3


class Notes:
    def __init__(self):
        self.names = {}

    def add(self, sentence, name):
        """`sentence` goes before the names of all that it is true of."""
        self.names.setdefault(sentence, []).append(name)

    def hand_over(self, out):
        for sentence, names in self.names.items():
            more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
            out.text(handover.WARNING, f"{sentence}: {', '.join(names[:MOST_NAMED])}{more}")
