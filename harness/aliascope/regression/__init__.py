"""Whether what renders now is as good as what was blessed: what is observed of pictures, what is tested, what is kept.

Nothing here renders: `studies/regress*.py` does.
"""
