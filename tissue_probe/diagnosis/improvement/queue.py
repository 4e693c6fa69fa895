"""Several effects at once: a queue of moves, the one that promises most first.

Contents: which move is made next, and when no more is.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from tissue_probe.diagnosis.evidence.adequacy import SHARE, doubtful, leaves_only_noise, removes
from tissue_probe.diagnosis.evidence.posterior import RIVAL, evidence
from tissue_probe.diagnosis.fitting.effort import Effort
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.improvement.moves import (
    Kind,
    Move,
    Moves,
    better,
    families,
    is_elsewhere,
)

#: Moves that are made at once: each process makes two.
MOVES_AT_ONCE = 4
#: Models to which one more effect is sought at once: the moves of all of them are compared.
MODELS_AT_ONCE = 8
#: Responses after which no further move is made: on a record of 2 s they take some five seconds.
BUDGET = 10_000

#: Moves whose promise is worth little get this share of the effort of those whose promise holds.
UNRELIABLE = 0.5
Names = frozenset[str]


@dataclass
class Queue:
    """Models of so many effects, sought from those with one effect less.

    Attributes
    ----------
    base : Fit
        The model without any effect.
    moves : Moves
        The moves that may be made.
    known : dict
        The best fit of each set of effects that was tried, by their names.
    effort : Effort
        The work that was done.
    curtailed : bool
        Whether the budget ended a search before the promises did.
    """

    base: Fit
    moves: Moves
    known: dict[Names, Fit]
    effort: Effort
    curtailed: bool = False
    _waiting: list[Move] = field(default_factory=list)
    _extended: list[Fit] = field(default_factory=list)
    _spent: dict[bool, float] = field(default_factory=lambda: {True: 0.0, False: 0.0})
    _tried: Counter[Kind] = field(default_factory=Counter)

    def note(self, fits: Iterable[Fit]) -> None:
        """Keep fits that are the best of their sets of effects."""
        for fit in fits:
            names = frozenset(fit.composition.names)
            if better(fit, self.known.get(names), self.base):
                self.known[names] = fit

    def best(self, count: int) -> Fit | None:
        """Return the most probable model of so many effects beside the base."""
        whole = count + len(self.base.composition.names)
        fits = [fit for names, fit in self.known.items() if len(names) == whole]
        return max(fits, key=lambda fit: evidence(fit, self.base), default=None)

    def seek(self, sources: Sequence[Fit], count: int) -> None:
        """Make moves from models until no promise can change the answer, or the budget is spent.

        Parameters
        ----------
        sources : sequence of Fit
            Models of one effect less, the most probable first.
        count : int
            Effects beside the base of the models that are sought.
        """
        self._waiting, self._extended, self._tried = [], [], Counter()
        self._spent = {True: 0.0, False: 0.0}
        sources = list(sources)
        with self.effort.count_responses():
            while not self._is_spent():
                few = self._next(count)
                if few:
                    self._make(few, count)
                elif is_enough(best := self.best(count)):
                    break
                elif best is not None and self._extend_in_turn(best):
                    continue
                elif sources:
                    self._extend(sources[:MODELS_AT_ONCE])
                    sources = sources[MODELS_AT_ONCE:]
                else:
                    break
            self.curtailed |= self._is_spent()

    def _is_spent(self) -> bool:
        return self.effort.done > BUDGET

    def _next(self, count: int) -> list[Move]:
        """Return the moves that are made next: those of one kind that promise most.

        Effects of a family already tried come after those of other families: it takes its place in
        the best model at once, see ``_neighbours``. The parts of the best model come first.
        """
        best = self.best(count)
        self._waiting = [move for move in self._waiting if self._is_open(move)]
        few: dict[Names, Move] = {}
        for move in sorted(self._waiting, key=lambda move: -move.promised):
            if self._is_worth(move, best):
                few.setdefault(move.names, move)
        fewer = self.best(count - 1)
        alike = [move for move in few.values() if fewer and self._has_parts_of(move, fewer)]
        chosen = alike[:MOVES_AT_ONCE] or self._various(self._of_one_kind(few.values()))
        self._waiting = [move for move in self._waiting if move not in chosen]
        self._tried.update(move.kind for move in chosen)
        return chosen

    def _of_one_kind(self, moves: Iterable[Move]) -> list[Move]:
        """Return the moves whose promise is reliable, or the others where it is their turn."""
        reliable: list[Move] = []
        others: list[Move] = []
        for move in moves:
            (reliable if move.reliable else others).append(move)
        owed = self._spent[False] < UNRELIABLE * self._spent[True]
        return others if not reliable or (others and owed) else reliable

    def _has_parts_of(self, move: Move, fewer: Fit) -> bool:
        """Whether a move leads to the families of a model with an effect less, apart.

        An effect that contains another, as Hertz's law lost contact, stands for both in one form,
        beside which no other form of its law is tried.
        """
        return move.kind[1] == self.moves.parts(fewer.composition.effects)

    def _various(self, moves: Sequence[Move]) -> list[Move]:
        """Return the first of moves, those of families first that were tried less often."""
        tried, order = self._tried.copy(), []
        for place, move in enumerate(moves):
            order.append((tried[move.kind], place))
            tried[move.kind] += 1
        return [moves[place] for _, place in sorted(order)[:MOVES_AT_ONCE]]

    def _is_open(self, move: Move) -> bool:
        """Whether a move promises more than its effects reached from other sides, and than none.

        Where no promise is worth much, each side is tried; and the most promising move in any case:
        a search may find more than was promised.
        """
        if not (move.reliable and self._tried):
            return True
        known = [
            self.known.get(names) for names in (move.names, frozenset(move.fit.composition.names))
        ]
        reached = max(evidence(fit, self.base) for fit in known if fit is not None)
        return move.promised > reached

    def _is_worth(self, move: Move, best: Fit | None) -> bool:
        """Whether a move may change the answer.

        Where none explains the measurements, a promise that is worth little is no reason against.
        """
        enough = is_enough(best)
        if not (enough or (move.reliable and self._tried)):
            return True
        reached = max(evidence(fit, self.base) for fit in self.known.values())
        return move.promised > reached - (RIVAL if enough else 0.0)

    def _make(self, few: Sequence[Move], count: int) -> None:
        """Make moves; the neighbours of a model better than all before are tried at once."""
        fewer, done = self.best(count - 1) or self.base, self.effort.done
        before = self.best(count) or fewer
        found = self.moves.fit_moves(few, self._find_cost_needed(fewer))
        while True:
            self.note(found)
            better = [
                fit
                for fit in found
                if self.known.get(frozenset(fit.composition.names)) is fit
                and evidence(fit, self.base) > evidence(before, self.base)
                and removes(fewer, fit)
            ]
            if not better:
                break
            before = self.best(count) or before
            found = [
                each
                for fit in better
                for each in self._neighbours(fit, self._find_cost_needed(fewer))
            ]
        self._spent[few[0].reliable] += self.effort.done - done

    def _neighbours(self, fit: Fit, needed: float) -> list[Fit]:
        """Fit models that have another effect of the same family, or a nested one, in one's place.

        A model without one of its effects is extended by others later, too.
        """
        self._extend_in_turn(fit)
        names = frozenset(fit.composition.names)
        kin = [
            move
            for move in self._waiting
            if names.issuperset(move.fit.composition.names)
            and move.families == families(fit)
            and (self._is_open(move) if move.reliable else move.names not in self.known)
        ]
        self._waiting = [move for move in self._waiting if move not in kin]
        return [*self.moves.fit_nested(fit), *self.moves.fit_moves(kin, needed)]

    def _extend_in_turn(self, fit: Fit) -> list[Fit]:
        """Extend a model without each of its effects; return those that are new.

        An effect that was found badly alone is found well beside another one, and leads further
        from there.
        """
        rest = self.moves.remainders(fit)
        new = [each for each in rest if self._is_new(each)]
        self.note(rest)
        self._extend(new)
        return new

    def _find_cost_needed(self, fewer: Fit) -> float:
        """Return the cost that is asked of a model, given the best one of an effect less."""
        enough = fewer.floor * (1.0 + (1.0 - SHARE) * (fewer.ratio**2 - 1.0))
        return min(enough, *(fit.cost for fit in self.known.values()))

    def _is_new(self, fit: Fit) -> bool:
        """Whether no model like this one was extended yet."""
        names = frozenset(fit.composition.names)
        own = [each for each in self._extended if frozenset(each.composition.names) == names]
        return all(is_elsewhere(fit, each) for each in own)

    def _extend(self, fits: Sequence[Fit]) -> None:
        """Let one more effect be added to models."""
        new = [fit for fit in fits if self._is_new(fit)]
        self._extended += new
        self._waiting += self.moves.longer(new)


def is_enough(best: Fit | None) -> bool:
    """Whether a model leaves noise only, and no rounding of an encoder may hide more."""
    return best is not None and leaves_only_noise(best) and not doubtful(best)


def begin_queue(base: Fit, moves: Moves, singles: Sequence[Fit], effort: Effort) -> Queue:
    """Return a queue that knows the base, and it with each effect alone."""
    queue = Queue(base, moves, {}, effort)
    queue.note([base, *singles])
    return queue
