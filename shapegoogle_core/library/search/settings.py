# SPDX-License-Identifier: MIT
"""`SearchSettings`: every choice of a search in one value, readable without importing numpy.

``docs/measurements/search.md`` holds the measurements behind the default values.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

__all__ = [
    "RANKS",
    "CandidateSettings",
    "EvidenceSettings",
    "FamilySettings",
    "Rank",
    "RerankSettings",
    "SearchSettings",
    "VerificationSettings",
    "WalkSettings",
]


Rank = Literal["shape", "kind", "both"]

RANKS: tuple[Rank, ...] = get_args(Rank)
"""Orders of a list: by the same shape, by the same kind, or the same shape first and then the same kind."""


@dataclass(frozen=True)
class CandidateSettings:
    """Selection of the shapes that are compared with the query by their bags.

    Attributes
    ----------
    count : int
        Number of shapes with the nearest codes that are compared by their full bags.
    per_match : int
        Least number of candidates for each requested match: codes order shapes only roughly.
    oversampling : int
        Oversampling factor before the codes are ordered by asymmetric distance.
    sharing : int
        Number of shapes with most of the query's local words whose support in space is computed, for each
        scale of the query; 0 to search no shapes by their
        local words.
    supported : int
        Number of pairs of shape and scale, the best by their support, that are kept of these.
    rank_unit, rank_power : float
        A pair is ordered by support · (1 + r / unit)^-power, with r its rank by local words.
    max_removed : int
        Number of codes of removed shapes that are kept in memory and skipped before all codes are read again.
    stages : tuple of str
        Names of the stages whose candidates are compared: "codes", the nearest by their codes, and those of
        plug-ins. Without "codes" a list can be shorter than requested.
    """

    count: int = 300
    per_match: int = 4
    oversampling: int = 4
    sharing: int = 800
    supported: int = 400
    rank_unit: float = 50.0
    rank_power: float = 0.25
    max_removed: int = 1_000
    stages: tuple[str, ...] = ("codes",)


@dataclass(frozen=True)
class RerankSettings:
    """Comparison of full bags, and the order of the matches in the end.

    Attributes
    ----------
    entries_at_once : int
        Bag entries in memory at once; 8 million are 32 MB as float32.
    unlike_weight : float
        Weight w of negative examples, see `Query`. Below 1, because a negative example is usually picked from
        the best matches and is similar to the query: with w = 1 a right match that was described worse than
        the example would fall with it.
    reranker : str or None
        Name of the re-ranker of a plug-in, which orders the matches in the end.
    """

    entries_at_once: int = 8_000_000
    unlike_weight: float = 1 / 8
    reranker: str | None = None


@dataclass(frozen=True)
class VerificationSettings:
    """Geometric verification: alignment of the best candidates with the query.

    Verification is skipped where bags are certain: they know more about a shape in another pose than an
    alignment does, which finds another individual in the query's own pose.

    Attributes
    ----------
    candidates : int
        Number of the best candidates by their bags that verification may consider.
    certain : float
        Similarity of the best match by its bags from which verification is skipped.
    certain_of_several : float
        The same for a query of several examples, copies of the examples left out. Several examples show how a
        shape varies, an alignment knows each of them in one pose.
    certain_of_cut : float
        The same for a query with an opening or a closed hole: what is missing of it changes its bags.
    first : int
        Number of matches that are aligned first.
    likely : float
        Similarity of one of the first matches from which no others are considered.
    next, next_relatives : int
        Number of further matches that are aligned: of the best by their bags, and of the shapes proposed by
        their local words alone.
    support_gain : float
        k in d exp(-k support), which orders these; d is the distance of the bags.
    finely : int
        Number of these further matches that are aligned finely: those that agree most after a rough
        alignment.
    rough_fits : int
        Number of shapes with common local words, the most promising ones, that are aligned roughly.
    exact_fits : int
        Number of shapes with common local words, roughly aligned, that are fitted exactly.
    exact_fits_of_aligned : int
        Number of aligned matches, those that cover most of the query, that are fitted exactly.
    exact_from, exact_gain : float
        e0 and k in d exp(-k (e - e0)), where a share e > e0 of the query fits exactly.
    surely_exact : float
        Share of the query that fits exactly from which no others are aligned.
    bent_half, bent_exponent : float
        x½ and k in the odds (x½ / x)ᵏ that a query whose local heat differs by x, see `BentPart`, is a part
        of the candidate in another pose.
    bent_agreement : float
        Power of what an alignment has lowered the distance of the bags by that lowers the distance of local
        heat, too: each knows something that the other one does not.
    bent_whole : float
        Share of the medial axis of a candidate, covered by the query, from which the query is no part of it:
        local heat is not asked. It is different where limbs are swollen.
    bent_exact : float
        Share of the query that fits exactly from which local heat says nothing against an alignment. A part
        of the candidate has more, a part of a relative in the same pose less.
    """

    candidates: int = 300
    certain: float = 0.7
    certain_of_several: float = 0.5
    certain_of_cut: float = 0.9
    first: int = 12
    likely: float = 0.9
    next: int = 40
    next_relatives: int = 16
    support_gain: float = 5.0
    finely: int = 24
    rough_fits: int = 120
    exact_fits: int = 24
    exact_fits_of_aligned: int = 8
    exact_from: float = 0.4
    exact_gain: float = 8.0
    surely_exact: float = 0.7
    bent_half: float = 0.64
    bent_exponent: float = 3.6
    bent_agreement: float = 0.2
    bent_whole: float = 0.75
    bent_exact: float = 0.55

    def enough(self, *, several: bool, cut: bool) -> float:
        """Return the similarity by bags from which verification is skipped.

        Parameters
        ----------
        several : bool
            Whether the query has several examples.
        cut : bool
            Whether one of them is cut off somewhere.

        Returns
        -------
        similarity : float
        """
        if several:
            return self.certain_of_several
        return self.certain_of_cut if cut else self.certain


@dataclass(frozen=True)
class EvidenceSettings:
    """Explanation of the best matches. Lengths are in units of the square root of the query's area.

    Attributes
    ----------
    explained : int
        Number of best matches that `Library.explain` and the command line explain by default.
    max_filtered : int
        Largest number of matches that are explained to find those of the kind in a `Filter`.
    identical : float
        Largest deviation of a copy whose points have the same numbers as the query's. Preprocessing rounds no
        better.
    remeshed : float
        Tolerance for "re-meshed": the largest deviation of another mesh of the same surface.
    flat : float
        Tolerance of the moments of two surfaces up to which they alone say that the two are the same.
    near : float
        Distance up to which a point is covered by a surface.
    coarse, coarse_near : float
        Instead of `remeshed` and of `near`, where only a sample of the query is known: its tangent planes are
        no more precise.
    whole : float
        Least share of either surface that lies on the other one if they are the same.
    part : float
        Least share of the smaller surface that lies on the larger one if it is a part of it: preprocessing
        closes cuts.
    largest_part : float
        Largest share of the whole that is called a part of it.
    same_size : float
        Largest relative difference of equal sizes.
    version : float
        Tolerance for "version": the largest deviation of a smoother, coarser or slightly changed surface.
    far, missing : float, float
        A part lacks something of its whole: the least share of the whole that is farther than `far` from it,
        as a multiple of the share that it lacks by its area. A smoothed surface is smaller, but lacks
        nothing.
    promising, widely : float
        Least share of one surface that fits the other one exactly, by their samples, for a fit to its faces;
        or that lies roughly on it, which is enough for a version.
    other_spectrum : float
        Difference of the lowest eigenvalues from which no other pose is considered.
    least_residual : float
        Deviation from a rotation that the best functional maps between two poses have. Where the probability
        of another pose is too small even with this one, no map is computed.
    fewest_modes : int
        Number of eigenfunctions that must vary on both surfaces for another pose to be considered.
    pose_weights : (float, float, float)
        Weights of the logistic regression behind the probability of another pose, for the features of
        `pose_features`; made by ``python -m benchmarks evidence --calibrate``.
    pose_offset : float
        Its constant.
    """

    explained: int = 50
    max_filtered: int = 200
    identical: float = 1e-3
    remeshed: float = 5e-3
    flat: float = 2e-4
    near: float = 1e-2
    coarse: float = 1.2e-2
    coarse_near: float = 2e-2
    whole: float = 0.95
    part: float = 0.85
    largest_part: float = 0.95
    version: float = 2e-2
    far: float = 4e-2
    missing: float = 0.37
    same_size: float = 2e-3
    promising: float = 0.4
    widely: float = 0.65
    other_spectrum: float = 0.35
    least_residual: float = 0.1
    fewest_modes: int = 8
    pose_weights: tuple[float, float, float] = (-2.79, -0.52, -1.26)
    pose_offset: float = -9.76


@dataclass(frozen=True)
class FamilySettings:
    """Families of matches, of which a search shows the best; see `shapegoogle_core.library.search.families`.

    Attributes
    ----------
    min_similarity : float
        Least similarity of a member to the leader by their bags.
    max_spectral_difference : float
        Largest root mean square of the logarithms of the ratios of their lowest eigenvalues.
    at_once : int
        Number of matches in memory at once.
    most_met : int
        Number of matches that a search goes through at most to find the requested number of families.
    """

    min_similarity: float = 0.95
    max_spectral_difference: float = 0.05
    at_once: int = 500
    most_met: int = 50_000


@dataclass(frozen=True)
class WalkSettings:
    """Walk over the neighbour graph, see `shapegoogle_core.library.neighbours.walk`.

    Attributes
    ----------
    links : int
        Number k of neighbours that a shape is linked with, besides copies.
    copies : int
        Largest number of copies that it is linked with.
    damping : float
        Probability α to go on after each step, from 0 to 1 (excluded).
    gain : float
        How much the distance of the most visited match is lowered, see `walked_distances`.
    unchanged : int
        Number of best matches that keep their places: of these the distances are certain enough.
    walked : int
        Number of best matches that the walk may move forwards.
    """

    links: int = 4
    copies: int = 2
    damping: float = 0.95
    gain: float = 3.0
    unchanged: int = 3
    walked: int = 300


@dataclass(frozen=True)
class SearchSettings:
    """Settings of a search, by stage.

    Attributes
    ----------
    candidates : CandidateSettings
        Selection of the shapes that are compared by their bags.
    rerank : RerankSettings
        Comparison of full bags.
    verification : VerificationSettings
        Alignment of the best candidates with the query.
    evidence : EvidenceSettings
        Explanation of the best matches.
    families : FamilySettings
        Shapes that are shown as versions of one.
    walk : WalkSettings
        Order of the matches behind the first few.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> from shapegoogle_core.library.search.settings import CandidateSettings
    >>> settings = sg.SearchSettings(candidates=CandidateSettings(count=1_000))
    >>> settings.candidates.oversampling, settings.verification.certain
    (4, 0.7)
    """

    candidates: CandidateSettings = field(default_factory=CandidateSettings)
    rerank: RerankSettings = field(default_factory=RerankSettings)
    verification: VerificationSettings = field(default_factory=VerificationSettings)
    evidence: EvidenceSettings = field(default_factory=EvidenceSettings)
    families: FamilySettings = field(default_factory=FamilySettings)
    walk: WalkSettings = field(default_factory=WalkSettings)
