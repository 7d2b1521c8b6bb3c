#!/usr/bin/env python3
"""Writes the golden files: what PyTorch computes in float64 for the layers, the losses and whole SAC updates.

Usage: /usr/bin/python3 tests/golden/make_golden.py      (Debian's python3-torch; the tests need neither)

Inputs and parameters come from a hash of (salt, index), which golden.h repeats, so only results are stored: as
float32, whose rounding (6e-8) is far below the tolerance (1e-5). The networks are written here in PyTorch's own terms
(nn.LSTM's kernel, keys and values formed, autograd), not in those of common/nn.
"""
import math
import os
import numpy as np
import torch
import torch.nn.functional as F

torch.set_default_dtype(torch.float64)
torch.set_num_threads(1)
HERE = os.path.dirname(os.path.abspath(__file__))
VEHICLES, HISTORY, UNITS = 6, 5, 56
MASK64 = (1 << 64) - 1


def uniform(salt, shape, scale=1.0):
    """float32 values in [-scale, scale): splitmix64 of (salt, index)."""
    count = int(np.prod(shape))
    with np.errstate(over='ignore'):
        z = np.arange(1, count + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
        z += np.uint64((salt * 0xD1342543DE82EF95) & MASK64)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        z ^= z >> np.uint64(31)
    unit = (z >> np.uint64(40)).astype(np.float32) * np.float32(2.0 ** -23) - np.float32(1.0)
    return (unit * np.float32(scale)).reshape(shape)


def tensor(array, grad=False):
    return torch.tensor(np.asarray(array, dtype=np.float64), requires_grad=grad)


def save(name, value):
    path = os.path.join(HERE, name + '.npy')
    os.makedirs(os.path.dirname(path), exist_ok=True)
    if isinstance(value, torch.Tensor):
        value = value.detach().numpy()
    value = np.asarray(value)
    np.save(path, value if value.dtype == np.uint8 else value.astype(np.float32))


def linear_shapes(prefix, inputs, outputs):
    return [(prefix + '.weight', (outputs, inputs), inputs), (prefix + '.bias', (outputs,), inputs)]


# --- the networks, by parameter name ---------------------------------------------------------------------------------

CONVS = [(4, 2, 5), (8, 4, 5), (16, 8, 5), (32, 16, 5), (64, 32, 3)]


def encoder_shapes(stae, context):
    shapes = []
    if stae:
        lstm = 'encoder.stae.lstm.'
        shapes += [(lstm + 'weight_ih', (4 * UNITS, 7), UNITS), (lstm + 'weight_hh', (4 * UNITS, UNITS), UNITS),
                   (lstm + 'bias', (4 * UNITS,), UNITS)]
        for part in ('query', 'key', 'value', 'output'):
            shapes += linear_shapes('encoder.stae.attention.' + part, UNITS, UNITS)
        shapes += linear_shapes('encoder.stae.output', 20 + UNITS, 128)
    if context:
        for i, (out, inputs, kernel) in enumerate(CONVS):
            fan_in = inputs * kernel * kernel
            shapes += [(f'encoder.context.conv{i + 1}.weight', (out, inputs, kernel, kernel), fan_in),
                       (f'encoder.context.conv{i + 1}.bias', (out,), fan_in)]
        shapes += linear_shapes('encoder.context.output', 256, 128)
    return shapes


def mlp_shapes(prefix, inputs, hidden, outputs):
    return (linear_shapes(prefix + '.hidden1', inputs, hidden) + linear_shapes(prefix + '.hidden2', hidden, hidden) +
            linear_shapes(prefix + '.output', hidden, outputs))


def make_parameters(salt, shapes):
    result = {}
    for i, (name, shape, fan_in) in enumerate(shapes):
        bound = np.float32(1) / np.sqrt(np.float32(fan_in))
        result[name] = tensor(uniform(salt * 1000 + i, shape, bound), True)
    return result


def flat(values):
    return np.concatenate([v.detach().numpy().ravel() for v in values])


def dense(p, prefix, x):
    return F.linear(x, p[prefix + '.weight'], p[prefix + '.bias'])


def attention(p, prefix, hidden, absent):
    """hidden [B, 1 + V, U], the ego first; absent [B, V] bool. The residual sum [B, U] and the weights."""
    q = dense(p, prefix + '.query', hidden[:, :1])
    k = dense(p, prefix + '.key', hidden[:, 1:])
    v = dense(p, prefix + '.value', hidden[:, 1:])
    zero = torch.zeros_like(k[:, :1])
    k, v = torch.cat([k, zero], 1), torch.cat([v, zero], 1)
    mask = F.pad(absent, (0, 1), value=False)
    score = (q @ k.transpose(1, 2)).squeeze(1) / math.sqrt(k.shape[-1])
    weight = torch.softmax(score.masked_fill(mask, -math.inf), -1)
    context = (weight.unsqueeze(1) @ v).squeeze(1)
    return hidden[:, 0] + dense(p, prefix + '.output', context), weight[:, :-1]


def lstm_last(weight_ih, weight_hh, bias, sequences):
    """sequences [N, T, F] to the last hidden state [N, U]; the second bias of PyTorch is zero."""
    zero = torch.zeros(1, sequences.shape[0], weight_hh.shape[1])
    weights = [weight_ih, weight_hh, bias, torch.zeros_like(bias)]
    return torch._VF.lstm(sequences, (zero, zero), weights, True, 1, 0.0, False, False, True)[1][0]


def encode(p, observation, stae=True, context=True):
    vehicles, ego, planes = observation
    batch = ego.shape[0]
    parts = []
    if stae:
        sequences = torch.cat([ego[:, :, :7].unsqueeze(1), vehicles], 1).reshape(-1, HISTORY, 7)
        lstm = 'encoder.stae.lstm.'
        hidden = lstm_last(p[lstm + 'weight_ih'], p[lstm + 'weight_hh'], p[lstm + 'bias'], sequences)
        absent = vehicles[:, :, -1, 0] > 0.5
        summed, _ = attention(p, 'encoder.stae.attention', hidden.view(batch, 1 + VEHICLES, UNITS), absent)
        normal = F.layer_norm(summed, (UNITS,))
        parts.append(F.relu(dense(p, 'encoder.stae.output', torch.cat([ego[:, -1], normal], 1))))
    else:
        parts += [ego.flatten(1), vehicles.flatten(1)]
    if context:
        x = planes
        for i in range(len(CONVS)):
            name = f'encoder.context.conv{i + 1}'
            x = F.relu(F.conv2d(x, p[name + '.weight'], p[name + '.bias'], stride=2))
        parts.append(F.relu(dense(p, 'encoder.context.output', x.flatten(1))))
    return torch.cat(parts, 1)


def mlp(p, prefix, x, layer_norm):
    for name in ('.hidden1', '.hidden2'):
        x = dense(p, prefix + name, x)
        if layer_norm:
            x = F.layer_norm(x, (x.shape[-1],))
        x = F.relu(x)
    return dense(p, prefix + '.output', x)


def sample(output, noise, low=-5.0, high=2.0):
    mean, log_std = output.chunk(2, -1)
    log_std = log_std.clamp(low, high)
    u = mean + log_std.exp() * noise
    normal = torch.distributions.Normal(mean, log_std.exp())
    log_probability = normal.log_prob(u) - 2 * (math.log(2) - u - F.softplus(-2 * u))
    return torch.tanh(u), log_probability.sum(-1)


# --- inputs ----------------------------------------------------------------------------------------------------------

BATCH = 18  # no multiple of sixteen: the second block is mostly padding


def make_vehicles(salt):
    """Padded histories everywhere, gone vehicles with a past, one sample with nobody, one with everybody."""
    vehicles = uniform(salt, (BATCH, VEHICLES, HISTORY, 7))
    vehicles[..., 0] = 0
    for b in range(BATCH):
        for v in range(VEHICLES):
            seen = (b * 5 + v * 3 + salt) % 8  # rows seen, newest last; more than HISTORY - 1 is all
            vehicles[b, v, :max(HISTORY - seen, 0)] = [1, 0, 0, 0, 0, 0, 0]
            if (b + v + salt) % 7 == 0:
                vehicles[b, v, -1] = [1, 0, 0, 0, 0, 0, 0]
    vehicles[3] = [1, 0, 0, 0, 0, 0, 0]
    vehicles[17] = [1, 0, 0, 0, 0, 0, 0]
    vehicles[5, :, :, 0] = 0
    return vehicles


def make_planes(salt):
    """Bits [B, 4096]: a road, and a route along it."""
    y, x = np.mgrid[0:128, 0:128].astype(np.float64)
    c = uniform(salt, (BATCH, 4)).astype(np.float64)
    planes = np.zeros((BATCH, 2, 128, 128), dtype=np.uint8)
    for b in range(BATCH):
        centre = 64 + 40 * c[b, 0] + c[b, 1] * (y - 64)
        planes[b, 0] = (np.abs(x - centre) < 14) | (np.abs(y - 64 - 50 * c[b, 2]) < 9 + 6 * c[b, 3])
        planes[b, 1] = (np.abs(x - centre) < 3) & (y < 64)
    planes[4] = 0
    return np.packbits(planes.reshape(BATCH, -1), axis=1, bitorder='little')


def unpack(bits):
    return tensor(np.unpackbits(bits, axis=1, bitorder='little').reshape(BATCH, 2, 128, 128))


def make_ego(salt):
    ego = uniform(salt, (BATCH, HISTORY, 20))
    ego[..., 0] = 0
    ego[::4, :2, :7] = [1, 0, 0, 0, 0, 0, 0]
    return ego


# --- the files -------------------------------------------------------------------------------------------------------

def write_inputs():
    for k in range(4):
        save(f'inputs/vehicles{k}', make_vehicles(50 + k))
        save(f'inputs/ego{k}', make_ego(60 + k))
        save(f'inputs/context{k}', make_planes(70 + k))


def observation(k, context=True):
    planes = unpack(make_planes(70 + k)) if context else None
    return tensor(make_vehicles(50 + k)), tensor(make_ego(60 + k)), planes


def write_layers():
    p = {name: tensor(uniform(10 + i, shape, 0.5), True)
         for i, (name, shape, _) in enumerate(linear_shapes('l', 19, 21))}
    x = tensor(uniform(12, (BATCH, 19)), True)
    y = F.relu(dense(p, 'l', x))
    y.backward(tensor(uniform(13, (BATCH, 21))))
    save('linear/output', y)
    save('linear/input_gradient', x.grad)
    save('linear/gradient', flat([v.grad for v in p.values()]))

    shapes = [('weight_ih', (4 * UNITS, 7)), ('weight_hh', (4 * UNITS, UNITS)), ('bias', (4 * UNITS,))]
    p = {name: tensor(uniform(20 + i, shape, 0.3), True) for i, (name, shape) in enumerate(shapes)}
    sequences = tensor(make_vehicles(50)).reshape(-1, HISTORY, 7)
    last = lstm_last(*p.values(), sequences)
    last.backward(tensor(uniform(23, tuple(last.shape))))
    save('lstm/output', last)
    save('lstm/gradient', flat([v.grad for v in p.values()]))

    shapes = [s for part in ('query', 'key', 'value', 'output') for s in linear_shapes('a.' + part, UNITS, UNITS)]
    p = {name: tensor(uniform(30 + i, shape, 0.3), True) for i, (name, shape, _) in enumerate(shapes)}
    hidden = tensor(uniform(40, (BATCH, 1 + VEHICLES, UNITS)), True)
    absent = torch.tensor(make_vehicles(50)[:, :, -1, 0] > 0.5)
    summed, weight = attention(p, 'a', hidden, absent)
    summed.backward(tensor(uniform(41, (BATCH, UNITS))))
    save('attention/output', summed)
    save('attention/weights', weight)
    save('attention/hidden_gradient', hidden.grad)
    save('attention/gradient', flat([v.grad for v in p.values()]))

    x = tensor(uniform(42, (BATCH, UNITS)), True)
    y = F.layer_norm(x, (UNITS,))
    y.backward(tensor(uniform(43, (BATCH, UNITS))))
    save('layer_norm/output', y)
    save('layer_norm/input_gradient', x.grad)

    for layer_norm in (False, True):
        folder = 'mlp_layer_norm' if layer_norm else 'mlp'
        p = make_parameters(44, mlp_shapes('m', 30, 40, 3))
        x = tensor(uniform(45, (BATCH, 30)), True)
        y = mlp(p, 'm', x, layer_norm)
        y.backward(tensor(uniform(46, (BATCH, 3))))
        save(folder + '/output', y)
        save(folder + '/input_gradient', x.grad)
        save(folder + '/gradient', flat([v.grad for v in p.values()]))

    shapes = encoder_shapes(True, True)
    p = make_parameters(47, shapes)
    features = encode(p, observation(0))
    features.backward(tensor(uniform(48, tuple(features.shape))))
    save('encoder/output', features)
    save('encoder/gradient', flat([v.grad for v in p.values()]))


def write_losses():
    """Gradients of each loss with respect to what the networks put out. Some log-stds lie beyond their limits."""
    output = tensor(uniform(80, (BATCH, 4), 3.0), True)
    noise = tensor(uniform(81, (BATCH, 2), 2.0))
    action, log_probability = sample(output, noise, -2.0, 1.5)
    save('losses/action', action)
    save('losses/log_probability', log_probability)
    alpha = 0.25
    # Critics that are any smooth functions of the action.
    slope1, slope2 = tensor(uniform(82, (BATCH, 2))), tensor(uniform(83, (BATCH, 2)))
    q1 = (slope1 * action).sum(-1)
    q2 = (slope2 * action).sum(-1)
    loss = (alpha * log_probability - torch.min(q1, q2)).mean()
    loss.backward()
    save('losses/actor_loss', loss)
    save('losses/actor_gradient', output.grad)

    reward, weight = tensor(uniform(84, (BATCH,))), tensor(np.abs(uniform(85, (BATCH,))))
    discount = np.abs(uniform(86, (BATCH,)))
    discount[::5] = 0
    with torch.no_grad():
        target = reward + tensor(discount) * (torch.min(q1, q2) - alpha * log_probability)
    value1, value2 = tensor(uniform(87, (BATCH,)), True), tensor(uniform(88, (BATCH,)), True)
    loss = (weight * (value1 - target) ** 2).mean() + (weight * (value2 - target) ** 2).mean()
    loss.backward()
    save('losses/target', target)
    save('losses/critic_loss', loss)
    save('losses/value1_gradient', value1.grad)
    save('losses/value2_gradient', value2.grad)


def actor_batch(k):
    """Update k's scalars: n-step discounts 0.99^j for j = 1 to 3, zero where the episode terminated."""
    steps = 1 + (np.arange(BATCH) * 7 + k) % 3
    discount = (0.99 ** steps).astype(np.float32)
    discount[(np.arange(BATCH) + k) % 5 == 0] = 0
    weight = (0.25 + 0.75 * np.abs(uniform(93 + k, (BATCH,)))).astype(np.float32)
    return (uniform(90 + k, (BATCH, 2), 0.99), uniform(100 + k, (BATCH,), 2.0), discount, weight,
            uniform(110 + k, (BATCH, 2), 2.0), uniform(120 + k, (BATCH, 2), 2.0))


def write_batches():
    for k in range(3):
        for name, value in zip(('action', 'reward', 'discount', 'weight', 'next_noise', 'now_noise'), actor_batch(k)):
            save(f'inputs/{name}{k}', value)


class PaperEncoder:
    def __init__(self, context, stae=True):
        self.context, self.stae = context, stae
        self.features = (128 if stae else HISTORY * (20 + VEHICLES * 7)) + (128 if context else 0)
        self.shapes = encoder_shapes(stae, context)

    def __call__(self, p, seen):
        """The features of observation number `seen`, or of one of its views."""
        return encode(p, observation(seen, self.context) if isinstance(seen, int) else seen, self.stae, self.context)


VIEWS = 2  # of DrQ


def shifted(planes, draws, pixels):
    """Planes moved down and to the right by a uniform number of pixels each, from standard normal draws [B, 2]."""
    uniform01 = torch.distributions.Normal(0.0, 1.0).cdf(tensor(draws))
    shifts = (uniform01 * (2 * pixels + 1)).floor().int() - pixels
    padded = F.pad(planes, (pixels,) * 4, mode='replicate')
    rows, columns = (pixels - shifts).T.tolist()
    return torch.stack([p[:, r:r + 128, c:c + 128] for p, r, c in zip(padded, rows, columns)])


def views_of(k, salt, pixels):
    """Observation k as it is, or with `pixels` in VIEWS views, their planes shifted by draws of `salt`."""
    if pixels == 0:
        return [k]
    vehicles, ego, planes = observation(k, True)
    return [(vehicles, ego, shifted(planes, draws, pixels)) for draws in uniform(salt, (VIEWS, BATCH, 2), 2.0)]


def write_updates(case, shared, network, layer_norm, epsilon, updates=3, extras=(), step=1, before=None, pixels=0):
    """Of the tensors every `step`th number is stored. With `before(k, critic)`, which is called before each update, the
    discounts are those of single steps."""
    hidden, features = 32, network.features
    encoder = network.shapes
    flat = lambda values: np.concatenate([v.detach().numpy().ravel()[::step] for v in values])
    policy = make_parameters(1, encoder + mlp_shapes('policy', features, hidden, 4))
    critic = make_parameters(2, encoder + mlp_shapes('critic1', features + 2, hidden, 1) +
                             mlp_shapes('critic2', features + 2, hidden, 1))
    is_encoder = lambda name: name.startswith('encoder.')
    if shared:
        policy = {name: critic[name] if is_encoder(name) else value for name, value in policy.items()}
    target = {name: value.detach().clone() for name, value in critic.items()}
    average = [value.detach().clone() for value in policy.values()]
    policy_trained = [v for n, v in policy.items() if not (shared and is_encoder(n))]
    log_alpha = tensor(math.log(0.2), True)
    settings = {'lr': 3e-4, 'eps': epsilon}
    critic_adam = torch.optim.Adam(critic.values(), **settings)
    policy_adam = torch.optim.Adam(policy_trained, **settings)
    alpha_adam = torch.optim.Adam([log_alpha], **settings)
    run = network
    q = lambda p, x: (mlp(p, 'critic1', x, layer_norm)[:, 0], mlp(p, 'critic2', x, layer_norm)[:, 0])

    losses, errors = [], []
    for k in range(updates):
        action, reward, discount, weight, next_noise, now_noise = map(tensor, actor_batch(k))
        if before:
            before(k, critic)
            discount = tensor(np.where(discount > 0, np.float32(0.99), np.float32(0)))
        now, after = k, k + 1
        alpha = log_alpha.exp().detach()
        noises = [next_noise, tensor(uniform(130 + k, (BATCH, 2), 2.0))]
        targets = []
        for view, noise in zip(views_of(after, 150 + k, pixels), noises):
            with torch.no_grad():
                next_action, next_log = sample(mlp(policy, 'policy', run(policy, view), False), noise)
                t1, t2 = q(target, torch.cat([run(target, view), next_action], 1))
                targets.append(reward + discount * (torch.min(t1, t2) - alpha * next_log))
        y = torch.stack(targets).mean(0)
        critic_loss, means = 0, []
        for view in views_of(now, 140 + k, pixels):
            state = run(critic, view)
            q1, q2 = q(critic, torch.cat([state, action], 1))
            critic_loss = critic_loss + (weight * (q1 - y) ** 2).mean() + (weight * (q2 - y) ** 2).mean()
            means.append(0.5 * (q1 + q2).detach())
        mean_q = torch.stack(means)
        errors.append((mean_q - y).abs().mean(0).numpy())
        critic_adam.zero_grad(set_to_none=True)
        critic_loss.backward()
        critic_adam.step()

        if shared and pixels > 0:  # the views are not what the actor sees
            actor_state = critic_state = run(critic, now).detach()
        elif shared:
            actor_state = critic_state = state.detach()
        else:
            actor_state = run(policy, now)
            critic_state = run(critic, now).detach()
        new_action, log_probability = sample(mlp(policy, 'policy', actor_state, False), now_noise)
        a1, a2 = q(critic, torch.cat([critic_state, new_action], 1))
        actor_loss = (alpha * log_probability - torch.min(a1, a2)).mean()
        policy_adam.zero_grad(set_to_none=True)
        actor_loss.backward()
        policy_adam.step()

        alpha_loss = -(log_alpha * (log_probability.detach() - 2.0)).mean()
        alpha_adam.zero_grad(set_to_none=True)
        alpha_loss.backward()
        alpha_adam.step()
        with torch.no_grad():
            for name, value in critic.items():
                target[name].mul_(0.995).add_(value, alpha=0.005)
            decay = min(0.998, (1 + k) / (10 + k))
            for a, value in zip(average, policy.values()):
                a.mul_(decay).add_(value, alpha=1 - decay)
        losses.append([critic_loss.item(), actor_loss.item(), alpha_loss.item(), log_alpha.exp().item(),
                       -log_probability.mean().item(), mean_q.mean().item(), y.mean().item()])

    save(case + '/losses', losses)
    save(case + '/td_error', errors)
    save(case + '/log_alpha', log_alpha)
    if 'parameters' in extras:  # a shared encoder is stored once, with the critics
        save(case + '/policy', flat(policy_trained))
        save(case + '/critic', flat(critic.values()))
    if 'target' in extras:
        save(case + '/target', flat(target.values()))
    if 'average' in extras:
        save(case + '/average', flat(average))
    if 'moments' in extras:
        save(case + '/policy_first', flat([policy_adam.state[v]['exp_avg'] for v in policy_trained]))
        save(case + '/critic_first', flat([critic_adam.state[v]['exp_avg'] for v in critic.values()]))


# --- PPO -------------------------------------------------------------------------------------------------------------

# 4 trajectories of at most 4 steps: one terminates after 2, one is truncated after 3, the others go on.
ROLLOUT, LENGTH, STEPS, TERMINATED = 4, 4, [4, 2, 3, 4], [False, True, False, False]


def rollout_rows(values, salt):
    """The first (LENGTH + 1) * ROLLOUT rows of two golden batches, time first."""
    return tensor(np.concatenate([values(salt), values(salt + 1)])[:(LENGTH + 1) * ROLLOUT])


def density(action, output, low=-5.0, high=2.0):
    mean, log_std = output.chunk(2, -1)
    log_std = log_std.clamp(low, high)
    u = torch.atanh(action)
    return (torch.distributions.Normal(mean, log_std.exp()).log_prob(u) - torch.log(1 - action ** 2)).sum(-1)


def write_ppo(case, shared):
    """One update of two epochs in minibatches of at most 8 of 13 steps; recorded log-probabilities are a little off, as
    an older policy's are."""
    hidden, features, gamma, decay, clip, entropy_weight, most = 32, HISTORY * (20 + VEHICLES * 7) + 128, 0.95, 0.9, 0.2, 0.02, 0.5
    encoder = encoder_shapes(False, True)
    policy = make_parameters(1, encoder + mlp_shapes('policy', features, hidden, 4))
    value = make_parameters(2, encoder + mlp_shapes('value', features, hidden, 1))
    is_encoder = lambda name: name.startswith('encoder.')
    if shared:
        policy = {name: value[name] if is_encoder(name) else v for name, v in policy.items()}
    trained = [v for n, v in policy.items() if not (shared and is_encoder(n))]
    settings = {'lr': 3e-4, 'eps': 1e-5}
    policy_adam, value_adam = torch.optim.Adam(trained, **settings), torch.optim.Adam(value.values(), **settings)

    vehicles, ego = rollout_rows(make_vehicles, 50), rollout_rows(make_ego, 60)
    planes = torch.cat([unpack(make_planes(70)), unpack(make_planes(71))])[:(LENGTH + 1) * ROLLOUT]
    action = tensor(uniform(200, (LENGTH, ROLLOUT, 2), 0.99)).reshape(-1, 2)
    reward = tensor(uniform(201, (LENGTH, ROLLOUT), 2.0))
    see = lambda rows: (vehicles[rows], ego[rows], planes[rows])

    def outputs(rows):
        state = encode(value, see(rows), False, True)
        v = mlp(value, 'value', state, True)[:, 0]
        seen = state.detach() if shared else encode(policy, see(rows), False, True)
        return v, mlp(policy, 'policy', seen, False)

    rows = [t * ROLLOUT + b for t in range(LENGTH) for b in range(ROLLOUT) if t < STEPS[b]]
    with torch.no_grad():
        values, output = outputs(range((LENGTH + 1) * ROLLOUT))
        now = density(action, output[:LENGTH * ROLLOUT])
    recorded = tensor((now.numpy() + uniform(202, (LENGTH * ROLLOUT,), 0.3)).astype(np.float32))
    save(case + '/log_probability', recorded)
    trace = (now - recorded).exp().clamp(max=1.0)
    advantage, target = torch.zeros(LENGTH * ROLLOUT), torch.zeros(LENGTH * ROLLOUT)
    for b in range(ROLLOUT):
        # From the definition: a sum over the steps behind, each through the traces between.
        for t in range(STEPS[b]):
            factor, total = 1.0, 0.0
            for k in range(t, STEPS[b]):
                if k > t:
                    factor = factor * gamma * decay * trace[k * ROLLOUT + b]
                ends = k + 1 == STEPS[b] and TERMINATED[b]
                after = 0.0 if ends else values[(k + 1) * ROLLOUT + b]
                total = total + factor * (reward[k, b] + gamma * after - values[k * ROLLOUT + b])
            advantage[t * ROLLOUT + b] = total
            target[t * ROLLOUT + b] = values[t * ROLLOUT + b] + trace[t * ROLLOUT + b] * total
    save(case + '/advantage', advantage)
    save(case + '/value_target', target)
    chosen = advantage[rows]
    advantage[rows] = (chosen - chosen.mean()) / (chosen.std(unbiased=False) + 1e-8)

    sums, count = np.zeros(5), 0
    for epoch in range(2):
        order = np.argsort(uniform(210 + epoch, (len(rows),)), kind='stable')
        noise = tensor(uniform(220 + epoch, (len(rows), 2), 2.0))
        for first, end in ((0, len(rows) // 2), (len(rows) // 2, len(rows))):
            batch = [rows[place] for place in order[first:end]]
            v, output = outputs(batch)
            log_ratio = density(action[batch], output) - recorded[batch]
            ratio = log_ratio.exp()
            _, anew = sample(output, noise[first:end])
            surrogate = torch.min(ratio * advantage[batch], ratio.clamp(1 - clip, 1 + clip) * advantage[batch])
            policy_loss = (-surrogate + entropy_weight * anew).mean()
            value_loss = ((v - target[batch]) ** 2).mean()
            policy_adam.zero_grad(set_to_none=True)
            value_adam.zero_grad(set_to_none=True)
            (policy_loss + value_loss).backward()
            torch.nn.utils.clip_grad_norm_(trained, most)
            torch.nn.utils.clip_grad_norm_(value.values(), most)
            policy_adam.step()
            value_adam.step()
            sums += len(batch) * np.array([policy_loss.item(), value_loss.item(), -anew.mean().item(),
                                           (ratio - 1 - log_ratio).mean().item(),
                                           ((ratio < 1 - clip) | (ratio > 1 + clip)).double().mean().item()])
            count += len(batch)
    error = (target - values[:LENGTH * ROLLOUT])[rows]
    explained = 1 - error.var(unbiased=False) / target[rows].var(unbiased=False)
    save(case + '/scalars', list(sums / count) + [values[rows].mean().item(), target[rows].mean().item(), explained.item()])
    save(case + '/policy', flat(trained))
    save(case + '/value', flat(value.values()))


if __name__ == '__main__':
    write_inputs()
    write_layers()
    write_losses()
    write_batches()
    write_updates('update_separate', False, PaperEncoder(True), True, 1e-5, extras=('parameters', 'target'))
    write_updates('update_shared', True, PaperEncoder(True), False, 1e-5, extras=('parameters', 'target'))
    write_updates('update_separate_no_context', False, PaperEncoder(False), False, 1e-5, extras=('parameters', 'average'))
    write_updates('update_shared_no_context', True, PaperEncoder(False), True, 1e-5, extras=('parameters', 'average'))
    write_updates('update_default_epsilon', False, PaperEncoder(False), True, 1e-8, updates=1, extras=('moments',))
    write_updates('update_drq_separate', False, PaperEncoder(True, stae=False), True, 1e-5, extras=('parameters', 'target'), pixels=2)
    write_updates('update_drq_shared', True, PaperEncoder(True, stae=False), False, 1e-5, extras=('parameters', 'target'), pixels=2)
    write_ppo('ppo_separate', False)
    write_ppo('ppo_shared', True)
