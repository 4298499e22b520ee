"""A planner that the cycle waits for: the same questions give the same answers at the same tick."""

from control.replanning import Answer, Question, answered


class AtOnce:
    """Looks for a way when it is asked, and answers in the next cycle."""

    def __init__(self) -> None:
        """Begin without a question."""
        self._answer: Answer | None = None

    def ask(self, question: Question) -> None:
        """Look for a way.

        Args:
            question: what is wanted.
        """
        self._answer = answered(question)

    def answer(self) -> Answer | None:
        """Give the answer once.

        Returns:
            What was found, None if nothing was asked since.
        """
        answer, self._answer = self._answer, None
        return answer

    def close(self) -> None:
        """Release nothing. Safe to call twice."""
