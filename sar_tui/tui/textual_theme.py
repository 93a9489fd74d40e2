"""Conversion of a theme's colours to a Textual theme."""

from textual.theme import Theme as TextualTheme

from sar_tui.model.theme import Theme


def textual_theme(theme: Theme) -> TextualTheme:
    """Return the colours under Textual's names."""
    colors = theme.colors
    return TextualTheme(
        name=f"sar-{theme.name}",
        primary=colors.accent,
        secondary=colors.accent,
        accent=colors.accent,
        foreground=colors.text,
        background=colors.background,
        surface=colors.surface,
        panel=colors.surface,
        success=colors.positive,
        warning=colors.negative,
        error=colors.negative,
        dark=theme.dark,
        variables={
            "text-muted": colors.muted,
            "neutral": colors.neutral,
            "footer-key-foreground": colors.accent,
            "footer-description-foreground": colors.muted,
            "footer-background": colors.background,
            "border": colors.muted,
            "border-blurred": colors.muted,
            "input-selection-background": f"{colors.accent} 35%",
            "block-cursor-foreground": colors.background,
            "block-cursor-background": colors.accent,
        },
    )
