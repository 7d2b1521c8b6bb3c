#!/usr/bin/python3
"""The peer of learner_update and act_latency: the same SAC update and the same policy in PyTorch, as fast as Debian's can.

Usage: peer_torch.py [--seconds S] [CASE...]      e.g. "separate b64 t1" "shared b256 t2" "act b1"; without: these and more

Prints the JSON lines of learner_update and act_latency. Debian's PyTorch 1.13 with its stock BLAS would be a straw man, so it runs
with OpenBLAS, channels-last convolutions (oneDNN), multi-tensor Adam, memory that stays with the process, threads that
spin while they wait, and denormals flushed; acting takes the better of eager and frozen TorchScript. Images come as bytes, one a pixel: the unpacking of bits that our side pays
for is left out. Needs: apt-get install python3-torch python3-numpy libopenblas0-openmp
"""
import argparse
import json
import math
import os
import re
import statistics
import sys
import time

OPENBLAS = '/usr/lib/x86_64-linux-gnu/openblas-openmp'
DEFAULT_CASES = ['separate b64 t1', 'shared b64 t1', 'separate b256 t1', 'separate b64 t2', 'act b1']


def tune_process():
    """What libraries read when they are loaded needs a process that is started with it."""
    if os.environ.get('DADRL_PEER_TUNED'):
        return
    if not os.path.isdir(OPENBLAS):
        sys.exit('error: no OpenBLAS, without which the comparison is unfair: apt-get install libopenblas0-openmp')
    tuned = {'DADRL_PEER_TUNED': '1', 'LD_LIBRARY_PATH': OPENBLAS, 'OMP_WAIT_POLICY': 'active',
             'MALLOC_MMAP_THRESHOLD_': str(1 << 30), 'MALLOC_TRIM_THRESHOLD_': str(4 << 30), 'MALLOC_TOP_PAD_': str(64 << 20)}
    with open('/proc/cpuinfo') as info:
        if 'avx512f' in info.read():
            tuned.update(OPENBLAS_CORETYPE='SKYLAKEX', ATEN_CPU_CAPABILITY='avx512')
    os.execve(sys.executable, [sys.executable] + sys.argv, {**os.environ, **tuned})


if __name__ == '__main__':
    tune_process()
try:
    import torch
    import torch.nn.functional as F
except ImportError:
    sys.exit('error: no PyTorch: apt-get install python3-torch python3-numpy libopenblas0-openmp')

UNITS = 56
CONVS = [(2, 4, 5), (4, 8, 5), (8, 16, 5), (16, 32, 5), (32, 64, 3)]


class VehicleEncoder(torch.nn.Module):
    """LSTM over all sequences at once; attention folded for its one query, as ours."""

    def __init__(self):
        super().__init__()
        self.lstm = torch.nn.LSTM(7, UNITS, batch_first=True)
        self.query, self.key, self.value, self.mix = (torch.nn.Linear(UNITS, UNITS) for _ in range(4))
        self.output = torch.nn.Linear(20 + UNITS, 128)

    def forward(self, ego, vehicles):
        batch, count = vehicles.shape[0], vehicles.shape[1]
        sequences = torch.cat([ego[:, None, :, :7], vehicles], 1).flatten(0, 1)
        hidden = self.lstm(sequences)[1][0].view(batch, 1 + count, UNITS)
        ego_hidden, others = hidden[:, 0], hidden[:, 1:]
        query = self.query(ego_hidden)
        folded = query @ self.key.weight
        score = torch.einsum('bvu,bu->bv', others, folded) + (query @ self.key.bias)[:, None]
        score = (score / math.sqrt(UNITS)).masked_fill(vehicles[:, :, -1, 0] > 0.5, -math.inf)
        weight = torch.softmax(F.pad(score, (0, 1)), -1)[:, :-1]
        context = torch.einsum('bv,bvu->bu', weight, others)
        value = context @ self.value.weight.T + weight.sum(-1, keepdim=True) * self.value.bias
        summed = F.layer_norm(ego_hidden + self.mix(value), (UNITS,))
        return F.relu(self.output(torch.cat([ego[:, -1], summed], 1)))


class ContextEncoder(torch.nn.Module):
    def __init__(self):
        super().__init__()
        layers = [part for i, o, k in CONVS for part in (torch.nn.Conv2d(i, o, k, 2), torch.nn.ReLU(inplace=True))]
        self.convolutions = torch.nn.Sequential(*layers).to(memory_format=torch.channels_last)
        self.output = torch.nn.Linear(256, 128)

    def forward(self, planes):
        x = planes.float().contiguous(memory_format=torch.channels_last)
        return F.relu(self.output(self.convolutions(x).flatten(1)))


class Encoder(torch.nn.Module):
    def __init__(self):
        super().__init__()
        self.vehicles, self.context = VehicleEncoder(), ContextEncoder()

    def forward(self, observation):
        ego, vehicles, planes = observation
        return torch.cat([self.vehicles(ego, vehicles), self.context(planes)], 1)


def mlp(inputs, outputs, layer_norm):
    norm = [torch.nn.LayerNorm(256, elementwise_affine=False)] if layer_norm else []
    return torch.nn.Sequential(torch.nn.Linear(inputs, 256), *norm, torch.nn.ReLU(inplace=True), torch.nn.Linear(256, 256), *norm,
                               torch.nn.ReLU(inplace=True), torch.nn.Linear(256, outputs))


class Critic(torch.nn.Module):
    """Encoder and two heads."""

    def __init__(self):
        super().__init__()
        self.encoder, self.q1, self.q2 = Encoder(), mlp(258, 1, True), mlp(258, 1, True)

    def values(self, features, action):
        x = torch.cat([features, action], 1)
        return self.q1(x), self.q2(x)


class Policy(torch.nn.Module):
    def __init__(self):
        super().__init__()
        self.encoder, self.head = Encoder(), mlp(256, 4, False)

    def forward(self, ego, vehicles, planes):
        return torch.tanh(self.head(self.encoder((ego, vehicles, planes)))[:, :2])

    def sample(self, features):
        mean, log_std = self.head(features).chunk(2, 1)
        log_std = log_std.clamp(-5, 2)
        noise = torch.randn_like(mean)
        u = mean + log_std.exp() * noise
        log_probability = -0.5 * noise.square() - log_std - 0.5 * math.log(2 * math.pi) - 2 * (math.log(2) - u - F.softplus(-2 * u))
        return torch.tanh(u), log_probability.sum(1, keepdim=True)


class Sac:
    """One update as learner/algorithms/sac.h describes it; critic layer norm and averaged policy as in the default configuration."""

    def __init__(self, shared):
        torch.manual_seed(0)
        self.shared = shared
        self.policy, self.critic, self.target = Policy(), Critic(), Critic()
        if shared:
            self.policy.encoder = self.critic.encoder
        self.target.load_state_dict(self.critic.state_dict())
        self.target.requires_grad_(False)
        self.critic_parameters, self.target_parameters = list(self.critic.parameters()), list(self.target.parameters())
        self.policy_parameters = list(self.policy.parameters())
        self.average = [p.detach().clone() for p in self.policy_parameters]
        trained = self.policy.head.parameters() if shared else self.policy_parameters
        self.log_alpha = torch.zeros(1, requires_grad=True)
        adam = lambda parameters: torch.optim.Adam(parameters, 1e-3, foreach=True)
        self.critic_adam, self.policy_adam, self.alpha_adam = adam(self.critic_parameters), adam(trained), adam([self.log_alpha])

    def update(self, now, action, reward, discount, weight, after):
        alpha = self.log_alpha.exp().detach()
        with torch.no_grad():
            next_action, log_probability = self.policy.sample(self.policy.encoder(after))
            value = torch.min(*self.target.values(self.target.encoder(after), next_action))
            target = reward + discount * (value - alpha * log_probability)
        features = self.critic.encoder(now)
        q1, q2 = self.critic.values(features, action)
        critic_loss = (weight * (q1 - target).square()).mean() + (weight * (q2 - target).square()).mean()
        self.step(self.critic_adam, critic_loss)

        critic_features = features = features.detach()
        if not self.shared:
            features = self.policy.encoder(now)
            with torch.no_grad():
                critic_features = self.critic.encoder(now)
        new_action, log_probability = self.policy.sample(features)
        for head in (self.critic.q1, self.critic.q2):
            head.requires_grad_(False)
        value = torch.min(*self.critic.values(critic_features, new_action))
        self.step(self.policy_adam, (alpha * log_probability - value).mean())
        for head in (self.critic.q1, self.critic.q2):
            head.requires_grad_(True)
        self.step(self.alpha_adam, -(self.log_alpha * (log_probability.detach().mean() - 2.0)).sum())
        with torch.no_grad():
            torch._foreach_mul_(self.target_parameters, 0.995)
            torch._foreach_add_(self.target_parameters, self.critic_parameters, alpha=0.005)
            torch._foreach_mul_(self.average, 0.998)
            torch._foreach_add_(self.average, self.policy_parameters, alpha=0.002)
        return critic_loss.item()

    @staticmethod
    def step(optimizer, loss):
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        optimizer.step()


def road(batch):
    """Ego, vehicles (some absent) and pictures of a road with a crossing and a route."""
    ego, vehicles = torch.rand(batch, 5, 20) * 2 - 1, torch.rand(batch, 6, 5, 7) * 2 - 1
    absent = torch.arange(6)[None, :] >= torch.randint(0, 7, (batch, 1))
    vehicles[absent] = torch.tensor([1.0, 0, 0, 0, 0, 0, 0])
    vehicles[..., 0] = absent[..., None].float()
    y, x = torch.meshgrid(torch.arange(128.0), torch.arange(128.0), indexing='ij')
    planes = torch.zeros(batch, 2, 128, 128, dtype=torch.uint8)
    for pair in planes:
        across = x - 54 - 20 * torch.rand(1) - (0.6 * torch.rand(1) - 0.3) * (y - 64)
        pair[0] = (across.abs() < 18) | ((y - 10 - 60 * torch.rand(1)).abs() < 18)
        pair[1] = (across.abs() < 3) & (y < 64)
    return ego, vehicles, planes


def seconds_of(function, seconds):
    """Median duration of a call, after a few to get warm."""
    for _ in range(3):
        function()
    durations = []
    end = time.perf_counter() + seconds
    while time.perf_counter() < end or len(durations) < 5:
        start = time.perf_counter()
        function()
        durations.append(time.perf_counter() - start)
    return statistics.median(durations)


def report(bench, case, value, unit):
    print(json.dumps({'bench': bench, 'case': case, 'value': float(f'{value:.4g}'), 'unit': unit}), flush=True)


def measure_update(case, encoders, batch, seconds):
    sac = Sac(encoders == 'shared')
    transitions = (road(batch), torch.rand(batch, 2) * 2 - 1, torch.rand(batch, 1) * 2 - 1, torch.full((batch, 1), 0.99),
                   torch.ones(batch, 1), road(batch))
    report('peer_torch', case, 1 / seconds_of(lambda: sac.update(*transitions), seconds), 'updates/s')


def measure_act(case, batch, seconds):
    policy, observation = Policy().eval(), road(batch)
    frozen = torch.jit.freeze(torch.jit.trace(policy, observation))
    best = math.inf
    with torch.inference_mode():
        for network in (policy, frozen):
            best = min(best, seconds_of(lambda: network(*observation), seconds / 2))
    report('peer_torch', case, best * 1e6, 'us')


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('cases', nargs='*', metavar='CASE', default=DEFAULT_CASES)
    parser.add_argument('--seconds', type=float, default=3.0, help='a case')
    options = parser.parse_args()
    torch.set_flush_denormal(True)
    for case in options.cases:
        found = re.fullmatch(r'(separate|shared|act) b(\d+)(?: t(\d+))?', case)
        if not found:
            parser.error(f"no case '{case}': separate|shared bBATCH tTHREADS, or act bBATCH")
        kind, batch, threads = found[1], int(found[2]), int(found[3] or 1)
        torch.set_num_threads(threads)
        if kind == 'act':
            measure_act(case, batch, options.seconds)
        else:
            measure_update(case, kind, batch, options.seconds)


if __name__ == '__main__':
    main()
